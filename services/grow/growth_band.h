#ifndef SPROUT_SERVICES_GROW_GROWTH_BAND_H_
#define SPROUT_SERVICES_GROW_GROWTH_BAND_H_

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/core/disparity_image.h"
#include "services/grow/growth_rule.h"
#include "services/grow/seed_queue.h"
#include "services/grow/similarity.h"

// Growth works on bands of rows. One-to-one matching couples the pixels of a row only, so a band
// has all it needs, and bands grow at the same time. What they give does not depend on how many do.
namespace sprout {

/// What growth may match a pixel to where the prior leaves it the two whole disparities on either
/// side, m = ⌊D_p⌋ and m + 1, and nothing else: in one number.
///   bits 0 to 7, 8 to 15   levels of their costs in the queue of seeds
///   bits 16 to 19          bit i: the better one among m + i − 2 to m + i; 0 for m, 1 for m + 1
///   bits 20, 21            whether they can be accepted
///   bit 22                 open: the prior leaves more; nothing else counts
class Candidates {
 public:
  static constexpr int kBetter = 16, kAccepted = 20, kOpen = 22;

  explicit Candidates(uint32_t packed = 0) : packed_(packed) {}

  bool IsOpen() const { return (packed_ >> kOpen & 1) != 0; }

  /// Of the three disparities around m + i − 1.
  unsigned Better(unsigned i) const { return packed_ >> (kBetter + i) & 1; }
  bool IsAccepted(unsigned which) const { return (packed_ >> (kAccepted + which) & 1) != 0; }
  int Level(unsigned which) const { return static_cast<int>(packed_ >> (8 * which) & 0xff); }

 private:
  uint32_t packed_;
};

/// What growth touches of a left pixel, in one place.
struct LeftPixel {
  static constexpr int16_t kFree = DisparityImage::kInvalid;  // not matched yet
  static constexpr int16_t kClosed = kFree + 1;               // can never be matched

  union {
    SeedQueue::Id next;     // matched: link of the queue of seeds
    Candidates candidates;  // free, unless the band is open
  };
  int16_t prior;      // counts
  int16_t disparity;  // px, or kFree or kClosed
};

/// m of Candidates, px.
inline int FirstCandidate(const LeftPixel& pixel) {
  static_assert(DisparityImage::kCountsPerPixel == 1 << 5);
  return pixel.prior >> 5;
}

/// The tables of one row. In a tabled band only the pixels and the steps outlast PrepareBand().
struct GrowthRow {
  LeftPixel* left;
  const uint8_t* sigma;   // of the prior, counts; only with EPC
  int32_t* left_energy;   // Σ w² of the window, with MNCC n²·var
  int32_t* right_energy;  // the same; negative where the window does not fit
  uint16_t* left_sum;     // Σ w, only with MNCC
  uint16_t* right_sum;
  std::array<int32_t*, 3> left_pairs;  // of the window's rows 0 and 1, 2 and 3, 4: see GrowthBand
  std::array<int32_t*, 3> right_pairs;
  // Only with candidates and rule.sub_pixel. Bit 0: the better candidate, 0 for m, 1 for m + 1;
  // above it, counts from its disparity to the least cost.
  int8_t* sub_pixel_steps;
};

/// A pixel of a band: its place in the tables `left` and `right_matched`. Its neighbours' are 1 and
/// stride() away.
using PixelId = SeedQueue::Id;

/// A seed, whole pixels.
struct GrowthSeed {
  int16_t u;
  int16_t v;  ///< row in the image
  int16_t disparity;
  SeedQueue::Id next;
};

/// A band of rows of one pair of images, with everything that growth looks at.
///
/// Windows are read as pairs of pixels, one above the other, in one number: the upper one in its
/// lower 16 bits. There is a row of pairs for every row, so a 5×5 window has its pixels in three of
/// them, which lie two rows apart; of the last only the upper pixels are the window's.
///
/// Where the prior is so sure of a pixel that it has two candidates, what there is to choose from
/// is computed before growth; where it is not, when the pixel is visited. In a tabled band all
/// pixels have candidates. Then there is memory for the pairs of one window and the energies of one
/// row at a time, which stays in the cache.
class GrowthBand {
 public:
  /// Which pixels have candidates: all, some, or none.
  enum class Kind { kTabled, kMixed, kOpen };

  static constexpr int kMostRows = 64;
  static constexpr int kPadding = 4;              ///< entries on either side of a row in each table
  static constexpr int kRunPixels = 16;           ///< neighbours that are looked at together
  static constexpr int32_t kOutside = INT32_MIN;  ///< right_energy where the window does not fit

  /// Rows of the bands of an image; the last may have fewer. As even as can be, so that none of two
  /// threads has a whole band more to do than the other.
  static int RowsPerBand(int height) {
    const int bands = (height + kMostRows - 1) / kMostRows;
    return (height + bands - 1) / bands;
  }

  /// @param size  of the images. Allocates when it, or what the rule needs, has changed.
  void Resize(cv::Size size, int first_row, const GrowthRule& rule, Kind kind);

  Kind kind() const { return kind_; }

  /// @param sigma  PriorMap::sigma; is read until the band has grown and is written.
  void SetSigma(const cv::Mat1b& sigma);

  /// @param row  −1 to rows().
  PixelId PixelAt(int row, int u) const {
    return static_cast<PixelId>((row + 1) * stride_ + kPadding + u);
  }
  int RowOf(PixelId pixel) const { return static_cast<int>(TableRowOf(pixel)) - 1; }
  int ColumnOf(PixelId pixel) const {
    return static_cast<int>(pixel - TableRowOf(pixel) * static_cast<PixelId>(stride_)) - kPadding;
  }

  /// A row of pairs, counted from the first row of the first windows: 0 to rows() + 3.
  int32_t* LeftPairs(int pair_row) { return left_pairs_.data() + PairsAt(pair_row); }
  int32_t* RightPairs(int pair_row) { return right_pairs_.data() + PairsAt(pair_row); }

  /// As long as a row of the image. @param i  0 to 3.
  int32_t* row_scratch(int i) { return row_scratch_.data() + i * stride_; }

  /// As long as a row of the image, and kRunPixels more.
  int16_t* prior_scratch() { return prior_scratch_.data(); }

  /// Entries from a row to the one below, in all tables.
  ptrdiff_t stride() const { return stride_; }

  int first_row() const { return first_row_; }
  int rows() const { return rows_; }
  int width() const { return size_.width; }
  cv::Size image_size() const { return size_; }

  /// @param row  0 to rows() − 1.
  const GrowthRow& row(int row) const { return views_[static_cast<size_t>(row)]; }

  /// Bytes of memory.
  size_t bytes() const;

  SeedQueue queue;
  std::span<GrowthSeed> seeds;  ///< initial seeds of the band, the owner's memory
  bool changed = false;         ///< has matched a pixel in the last round

  std::vector<LeftPixel> left;         ///< with a closed row above and below
  std::vector<uint8_t> right_matched;  ///< laid out as `left`

 private:
  void MakeViews();

  size_t PairsAt(int pair_row) const {
    return kRunPixels + kPadding + static_cast<size_t>(pair_row % pair_rows_ * stride_);
  }

  // A division by the stride.
  PixelId TableRowOf(PixelId pixel) const {
    return static_cast<PixelId>(pixel * rows_per_entry_ >> kRowFraction);
  }

  cv::Size size_;
  int first_row_ = 0;
  int rows_ = 0;
  ptrdiff_t stride_ = 0;
  // One by the stride, rounded up, in fixed point: exact for all pixels of a band.
  static constexpr int kRowFraction = 40;
  uint64_t rows_per_entry_ = 0;
  Kind kind_ = Kind::kOpen;
  int pair_rows_ = 0;
  std::vector<int32_t> left_energy_, right_energy_;
  std::vector<uint16_t> left_sum_, right_sum_;
  std::vector<int8_t> sub_pixel_steps_;
  std::vector<int32_t> left_pairs_, right_pairs_;
  std::vector<int32_t> row_scratch_;
  std::vector<int16_t> prior_scratch_;
  std::vector<GrowthRow> views_;
};

/// One pair of images and its prior.
struct GrowthInput {
  const cv::Mat1b& left;
  const cv::Mat1b& right;
  const PriorMap& prior;  ///< not looked at unless the similarity is EPC
};

/// Fills the band's tables: nothing is matched. O(pixels).
void PrepareBand(const GrowthInput& input, const GrowthRule& rule, GrowthBand& band);

/// Alg. 1 on the band's own seeds.
void GrowFromSeeds(const GrowthRule& rule, GrowthBand& band);

/// Disparities of a row, LeftPixel::kFree or kClosed where there is none.
using SeamRow = std::span<const int16_t>;

/// Alg. 1 from the pixels beyond the band's borders, matched by its neighbours: from the row above
/// first, each from left to right. Empty rows are left out.
void GrowFromSeams(const GrowthRule& rule, SeamRow above, SeamRow below, GrowthBand& band);

/// Writes the disparities to the band's rows of the map; with rule.sub_pixel to the counts of
/// DisparityImage, from the parabola through the costs of d − 1, d and d + 1.
void WriteBand(const GrowthRule& rule, const GrowthBand& band, DisparityImage& map);

/// Costs of d − 1, d and d + 1 at a pixel, kExcludedCost where a window does not fit.
/// @pre the left window lies in the image, the right window of d leaves it by one column at most.
CostTriple CostsAt(const GrowthRule& rule, const GrowthBand& band, int u, int v, int d);

}  // namespace sprout

#endif  // SPROUT_SERVICES_GROW_GROWTH_BAND_H_
