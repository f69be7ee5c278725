#include "services/batch/frame_rows.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <string_view>

#include "common/logfile/log_error.h"

namespace sprout::batch {
namespace {

constexpr size_t kFixedColumns = 4;  // log, shard, seq, utime

std::vector<std::string_view> Split(std::string_view line) {
  std::vector<std::string_view> cells;
  for (size_t at = 0;;) {
    const size_t end = line.find(',', at);
    cells.push_back(line.substr(at, end - at));
    if (end == std::string_view::npos) return cells;
    at = end + 1;
  }
}

template <typename T>
T Number(std::string_view text, T otherwise) {
  T number = otherwise;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

}  // namespace

FrameRows::FrameRows(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line)) throw LogError(path, "cannot be read");
  for (const std::string_view column : Split(line)) columns_.emplace_back(column);
  columns_.erase(columns_.begin(), columns_.begin() + kFixedColumns);
  while (std::getline(file, line)) {
    const std::vector<std::string_view> cells = Split(line);
    if (cells.size() != columns_.size() + kFixedColumns) throw LogError(path, "a row is damaged");
    if (logs_.empty() || logs_.back() != cells[0]) logs_.emplace_back(cells[0]);
    rows_.push_back({.log = static_cast<uint32_t>(logs_.size() - 1),
                     .shard = Number<uint32_t>(cells[1], 0),
                     .seq = Number<int64_t>(cells[2], -1),
                     .utime = Number<int64_t>(cells[3], 0)});
    for (size_t i = kFixedColumns; i < cells.size(); ++i) {
      values_.push_back(Number<float>(cells[i], std::numeric_limits<float>::quiet_NaN()));
    }
  }
}

std::vector<float> FrameRows::Column(const std::string& name) const {
  const auto found = std::find(columns_.begin(), columns_.end(), name);
  if (found == columns_.end()) return {};
  std::vector<float> column;
  column.reserve(rows_.size());
  for (size_t i = static_cast<size_t>(found - columns_.begin()); i < values_.size();
       i += columns_.size()) {
    column.push_back(values_[i]);
  }
  return column;
}

double MeanOf(const std::vector<float>& values) {
  double sum = 0;
  int64_t count = 0;
  for (const float value : values) {
    if (std::isnan(value)) continue;
    sum += value;
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace sprout::batch
