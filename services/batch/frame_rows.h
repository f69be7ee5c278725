#ifndef SPROUT_SERVICES_BATCH_FRAME_ROWS_H_
#define SPROUT_SERVICES_BATCH_FRAME_ROWS_H_

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sprout::batch {

/// A row of frames.csv.
struct FrameRow {
  uint32_t log = 0;  ///< number in FrameRows::logs
  uint32_t shard = 0;
  int64_t seq = 0;
  int64_t utime = 0;
};

/// frames.csv in memory: some 150 bytes a frame. NaN stands for an empty cell.
class FrameRows {
 public:
  /// @throws LogError.
  explicit FrameRows(const std::filesystem::path& path);

  const std::vector<FrameRow>& rows() const { return rows_; }
  const std::vector<std::string>& logs() const { return logs_; }  ///< names, as they came

  /// The values of a column, by row; empty when there is no such column.
  std::vector<float> Column(const std::string& name) const;

 private:
  std::vector<std::string> columns_;
  std::vector<FrameRow> rows_;
  std::vector<std::string> logs_;
  std::vector<float> values_;  // rows × columns_
};

/// Mean of the values without NaN; NaN if there are none.
double MeanOf(const std::vector<float>& values);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_FRAME_ROWS_H_
