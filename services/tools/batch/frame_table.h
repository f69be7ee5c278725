#ifndef SPROUT_SERVICES_TOOLS_BATCH_FRAME_TABLE_H_
#define SPROUT_SERVICES_TOOLS_BATCH_FRAME_TABLE_H_

#include <string>
#include <vector>

#include "services/tools/batch/batch_state.h"
#include "services/tools/batch/table.h"

namespace sprout::batch {

/// The frames of all logs that are done: measures and times of the variants beside each other, then
/// what differs. Some 16 bytes a cell.
class FrameTable {
 public:
  /// @throws LogError, Interrupted.
  FrameTable(const BatchFolder& folder, const Manifest& manifest, const BatchState& state);

  const Table& table() const { return table_; }
  size_t size() const { return table_.rows.size(); }
  int LogOf(size_t row) const { return logs_[row]; }
  int64_t SeqOf(size_t row) const { return static_cast<int64_t>(*table_.rows[row][0]); }

  /// The values of a column, by row, NaN where unknown; empty when there is no such column.
  std::vector<float> Column(const std::string& name) const;

 private:
  Table table_;
  std::vector<int> logs_;  // by row
};

/// Writes frames.csv. @throws LogError.
void WriteFrameTable(const BatchFolder& folder, const Manifest& manifest, const FrameTable& frames);

/// Mean of the values from `first` to before `last` without NaN; NaN if there are none.
double MeanOf(const std::vector<float>& values, size_t first, size_t last);
inline double MeanOf(const std::vector<float>& values) { return MeanOf(values, 0, values.size()); }

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_TOOLS_BATCH_FRAME_TABLE_H_
