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

/// What growth touches of a left pixel, in one place.
struct LeftPixel {
  static constexpr int16_t kFree = DisparityImage::kInvalid;  // not matched yet
  static constexpr int16_t kClosed = kFree + 1;               // can never be matched

  int32_t energy;      // Σ w² of its window; with MNCC n²·var
  SeedQueue::Id next;  // link of the queue of seeds
  int16_t prior;       // counts
  int16_t disparity;   // px, or kFree or kClosed
};

/// What growth touches of one row.
struct GrowthRow {
  LeftPixel* left;
  int32_t* right_energy;  // as of the left pixel; negative where the window does not fit
  uint8_t* right_matched;
  uint16_t* left_sum;  // Σ w, only with MNCC
  uint16_t* right_sum;
  int16_t* left_columns;  // the rows around this one, see GrowthBand
  int16_t* right_columns;
  const int16_t* window_rows;  // all bits set for the rows of a column that are in the window
};

/// A seed, whole pixels.
struct GrowthSeed {
  int16_t u;
  int16_t v;  ///< row in the image
  int16_t disparity;
  SeedQueue::Id next;
};

/// A band of rows of one pair of images, with everything that growth looks at.
///
/// Windows are read as columns of eight pixels (16 bits each) that lie side by side; there is one
/// set of columns for every four rows, so each 5×5 window is five neighbours of one set.
class GrowthBand {
 public:
  static constexpr int kRows = 64;
  static constexpr int kPadding = 4;     ///< columns on either side of what belongs to right pixels
  static constexpr int kColumnRows = 8;  ///< pixels in a column
  static constexpr int kRowsPerSet = 4;  ///< rows whose windows lie in one set of columns
  static constexpr int32_t kOutside = INT32_MIN;  ///< right_energy where the window does not fit

  /// @param size  of the images. Allocates when it differs from the last one.
  void Resize(cv::Size size, int first_row, bool with_sums);

  int first_row() const { return first_row_; }
  int rows() const { return rows_; }
  int width() const { return size_.width; }
  cv::Size image_size() const { return size_; }

  /// @param row  −1 to rows(): the rows above and below the band are closed.
  const GrowthRow& row(int row) const { return views_[static_cast<size_t>(row + 1)]; }

  /// Bytes of memory.
  size_t bytes() const;

  SeedQueue queue;
  std::span<GrowthSeed> seeds;  ///< initial seeds of the band, the owner's memory
  bool changed = false;         ///< has matched a pixel in the last round

  std::vector<LeftPixel> left;
  std::vector<int32_t> right_energy;
  std::vector<uint8_t> right_matched;
  std::vector<uint16_t> left_sum, right_sum;
  std::vector<int16_t> left_columns, right_columns;
  std::vector<int32_t> column_sums;  ///< two rows of scratch

 private:
  void MakeViews(bool with_sums);

  cv::Size size_;
  int first_row_ = 0;
  int rows_ = 0;
  std::vector<GrowthRow> views_;
};

/// One pair of images and its prior.
struct GrowthInput {
  const cv::Mat1b& left;
  const cv::Mat1b& right;
  const DisparityImage& prior;  ///< not looked at unless the similarity is EPC
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

/// Writes the disparities to the band's rows of the map; with sub_pixel to the counts of
/// DisparityImage, from the parabola through the costs of d − 1, d and d + 1.
void WriteBand(const GrowthRule& rule, const GrowthBand& band, bool sub_pixel, DisparityImage& map);

/// Costs of d − 1, d and d + 1 at a pixel, kExcludedCost where a window does not fit.
/// @pre the left window lies in the image, the right window of d leaves it by one column at most.
CostTriple CostsAt(const GrowthRule& rule, const GrowthBand& band, int u, int v, int d);

}  // namespace sprout

#endif  // SPROUT_SERVICES_GROW_GROWTH_BAND_H_
