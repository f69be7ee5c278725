#include "services/refine/stereo/stereo_search.h"

#include <algorithm>

namespace sprout::refine {

void SearchRows::Set(const StereoSearch& search) {
  const auto is_searched = [](int16_t first) { return first != StereoSearch::kNowhere; };
  const int width = search.first.cols;
  columns_.clear();
  begin_.assign(1, 0);
  for (int v = 0; v < search.first.rows; ++v) {
    const int16_t* row = search.first[v];
    const auto start = static_cast<int>(std::find_if(row, row + width, is_searched) - row);
    int end = width;
    while (end > start && !is_searched(row[end - 1])) --end;
    columns_.emplace_back(start, end);
    begin_.push_back(begin_.back() + static_cast<size_t>(end - start));
  }
}

}  // namespace sprout::refine
