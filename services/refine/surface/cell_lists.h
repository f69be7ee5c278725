#pragma once

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

namespace sprout::refine {

/// Points of an image sorted into square cells, the cells row by row in one array. The number of
/// points a cell is limited, so that searching around a point takes a bounded time wherever the
/// points lie. Keeps its memory when it is filled again: 4 bytes a point and 4 a cell.
class CellLists {
 public:
  /// @param positions  inside the image, px.
  /// @param side       of a cell, px.
  /// @param most       largest number of points of a cell; of a fuller one some are left out.
  /// @param thin       called for a fuller one: thin(indices) moves those to keep to the front and
  /// returns how many they are, at most `most`.
  /// O(points + cells): a counting sort; and what thin() takes.
  template <typename Thin>
  void Fill(std::span<const cv::Point2f> positions, cv::Size size, double side, size_t most,
            const Thin& thin) {
    const size_t fullest = Sort(positions, size, side);
    if (fullest > most) ThinOut(most, thin);
  }

  /// The indices of all points that were kept.
  std::span<const uint32_t> points() const { return points_; }

  /// Whether is_one(index) holds for any point in the cell of a position or the eight around it:
  /// tests all within a cell's side, and some beyond, until one holds.
  /// @param position  inside the image.
  /// Thread-safe.
  template <typename Predicate>
  bool AnyNeighbour(const cv::Point2f& position, const Predicate& is_one) const {
    const int column = Cell(position.x);
    const int row = Cell(position.y);
    const int first = std::max(column - 1, 0);
    const int last = std::min(column + 1, wide_ - 1);
    for (int y = std::max(row - 1, 0); y <= std::min(row + 1, high_ - 1); ++y) {
      // Cells side by side have their points side by side.
      const uint32_t end = begin_[CellIndex(last, y) + 1];
      for (uint32_t i = begin_[CellIndex(first, y)]; i < end; ++i) {
        if (is_one(size_t{points_[i]})) return true;
      }
    }
    return false;
  }

  /// Calls visit(index) for all of these points.
  template <typename Visit>
  void ForNeighbours(const cv::Point2f& position, const Visit& visit) const {
    AnyNeighbour(position, [&](size_t point) {
      visit(point);
      return false;
    });
  }

 private:
  // Returns how many points the fullest cell has.
  size_t Sort(std::span<const cv::Point2f> positions, cv::Size size, double side) {
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

  template <typename Thin>
  void ThinOut(size_t most, const Thin& thin) {
    uint32_t next = 0;
    for (size_t cell = 0; cell + 1 < begin_.size(); ++cell) {
      const std::span all(points_.begin() + begin_[cell], points_.begin() + begin_[cell + 1]);
      const size_t kept = all.size() > most ? thin(all) : all.size();
      std::copy_n(all.begin(), kept, points_.begin() + next);
      begin_[cell] = next;
      next += static_cast<uint32_t>(kept);
    }
    begin_.back() = next;
    points_.resize(next);
  }

  int Cell(float position) const { return static_cast<int>(position / side_); }
  size_t CellIndex(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(wide_) + static_cast<size_t>(x);
  }
  size_t CellOf(const cv::Point2f& position) const {
    return CellIndex(Cell(position.x), Cell(position.y));
  }

  double side_ = 1;
  int wide_ = 0;
  int high_ = 0;
  std::vector<uint32_t> begin_;   // of each cell in points_, and the end of the last
  std::vector<uint32_t> points_;  // by their index
};

}  // namespace sprout::refine
