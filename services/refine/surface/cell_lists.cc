#include "services/refine/surface/cell_lists.h"

#include <algorithm>

namespace sprout::refine {

size_t CellLists::Sort(std::span<const cv::Point2f> positions, cv::Size size, double side) {
  side_ = side;
  wide_ = static_cast<int>(size.width / side) + 1;
  high_ = static_cast<int>(size.height / side) + 1;
  begin_.assign(CellIndex(0, high_) + 1, 0);
  for (const cv::Point2f& position : positions) ++begin_[CellOf(position)];
  const uint32_t fullest = *std::max_element(begin_.begin(), begin_.end());
  uint32_t end = 0;
  for (uint32_t& cell : begin_) cell = end += cell;
  // Each cell is filled from its end, after which begin_ is what it says.
  points_.resize(positions.size());
  for (size_t i = positions.size(); i-- > 0;) {
    points_[--begin_[CellOf(positions[i])]] = static_cast<uint32_t>(i);
  }
  return fullest;
}

}  // namespace sprout::refine
