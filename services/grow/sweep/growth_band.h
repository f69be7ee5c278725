#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "services/grow/paper/growth_rule.h"

// The fast growth of open pixels for EPC. One-to-one matching couples the pixels of a row only, so
// bands of rows are independent and grow at the same time.
namespace sprout::grow {

/// Queue of seeds in the order of growth: the lowest level first, and within a level the seed that
/// was added last.
///
/// Each level is a chain of seeds. The links lie with the seeds, in the caller's memory: one cache
/// line a visit less than a queue that holds seeds itself. O(1) a seed.
class SeedQueue {
 public:
  using Id = uint32_t;
  static constexpr Id kNone = UINT32_MAX;

  SeedQueue() { first_.fill(kNone); }

  bool empty() const { return occupied_words_ == 0; }

  /// @param level  0 to kLevels − 1.
  /// @param next   the link that lies with this seed; a seed is in the queue once at a time.
  void Push(Id seed, int level, Id& next) {
    next = first_[static_cast<size_t>(level)];
    first_[static_cast<size_t>(level)] = seed;
    occupied_[static_cast<size_t>(level / 64)] |= uint64_t{1} << (level % 64);
    occupied_words_ |= 1u << (level / 64);
  }

  /// The first seed. @pre not empty.
  Id Top() const { return first_[static_cast<size_t>(BestLevel())]; }

  /// Takes the first seed out. @param next  its link. @pre not empty.
  void Pop(Id next) {
    const int level = BestLevel();
    first_[static_cast<size_t>(level)] = next;
    uint64_t& word = occupied_[static_cast<size_t>(level / 64)];
    word &= ~(uint64_t{next == kNone} << (level % 64));
    occupied_words_ &= ~(static_cast<uint32_t>(word == 0) << (level / 64));
  }

 private:
  int BestLevel() const {
    const int word = std::countr_zero(occupied_words_);
    return word * 64 + std::countr_zero(occupied_[static_cast<size_t>(word)]);
  }

  std::array<Id, kLevels> first_;
  std::array<uint64_t, kLevels / 64> occupied_{};  // bit n of word w: level 64w + n holds a seed
  uint32_t occupied_words_ = 0;                    // bit w: word w is not zero
};

/// All that growth reads and writes of a left pixel, in one place.
struct LeftPixel {
  static constexpr int16_t kFree = DisparityImage::kInvalid;  // open, and not matched yet
  static constexpr int16_t kClosed = kFree + 1;               // not open, and not matched

  union {
    SeedQueue::Id next;  // open and matched: link of the queue of seeds
    uint32_t sigma;      // otherwise: PriorMap::sigma
  };
  int16_t prior;      // counts
  int16_t disparity;  // px, or kFree or kClosed
};

/// State of a right pixel; kNoWindow: its window leaves the image.
enum RightState : uint8_t { kUnmatched, kMatched, kNoWindow };

/// A pixel of a band: its place in all of the band's tables, which have the same layout. Its
/// neighbours' are 1 and `stride` away.
using PixelId = SeedQueue::Id;

/// A band of rows of one pair of images, with everything that growth looks at.
struct GrowthBand {
  static constexpr int kPadding = 4;  ///< entries on either side of a row in each table
  static constexpr int kMargin = 2;   ///< rows above and below the band in each table
  static_assert(kPadding > kWindowRadius && kMargin == kWindowRadius);

  /// Allocates when the size has changed. @param size  of the images.
  void Resize(cv::Size size, int first_row);

  /// @param r  row of the band, −kMargin to rows + kMargin − 1.
  PixelId PixelAt(int r, int u) const {
    return static_cast<PixelId>((r + kMargin) * stride + kPadding + u);
  }

  cv::Size image_size;
  int first_row = 0;
  int rows = 0;
  int stride = 0;  ///< from a pixel to the one below

  SeedQueue queue;
  bool changed = false;  ///< has matched a pixel in the last round

  std::vector<LeftPixel> left;
  std::vector<uint8_t> right;  ///< RightState
  std::vector<uint8_t> left_grey, right_grey;

  std::vector<uint8_t> has_open;  ///< by row: whether a pixel is open

  /// Initial seeds, and their links in the queue.
  std::vector<Correspondence> seeds;
  std::vector<SeedQueue::Id> seed_links;
};

/// Disparities of a row as in LeftPixel.
using SeamRow = std::span<const int16_t>;

/// The functions compiled for each instruction set. All give the same bytes: they compute in whole
/// numbers, and in single operations of floating point that IEEE 754 defines to the last bit.
struct GrowthKernel {
  /// Fills the band's tables, besides the seeds: matched is what the map has, pixels that are not
  /// open. O(pixels).
  /// @param band  has_open is set.
  void (*prepare)(const GrowthRule& rule, const GrowthInput& input, const DisparityImage& map,
                  GrowthBand& band);

  /// Alg. 1 on the band's own seeds, and on what is matched beside open pixels, row by row.
  void (*grow_from_seeds)(const GrowthRule& rule, GrowthBand& band);

  /// Alg. 1 from the pixels beyond the band's borders, matched by its neighbours: from the row
  /// above first, each from left to right. Empty rows are left out.
  void (*grow_from_seams)(const GrowthRule& rule, SeamRow above, SeamRow below, GrowthBand& band);

  /// Writes the disparities of open pixels to the band's rows of the map; with rule.sub_pixel to
  /// the counts of DisparityImage (S2).
  void (*write)(const GrowthRule& rule, const GrowthInput& input, const GrowthBand& band,
                DisparityImage& map);
};

/// The one for the instruction set in use (--simd); null when that has no vectors of 16 bytes.
const GrowthKernel* FindGrowthKernel();

}  // namespace sprout::grow
