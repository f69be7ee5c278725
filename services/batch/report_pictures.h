#ifndef SPROUT_SERVICES_BATCH_REPORT_PICTURES_H_
#define SPROUT_SERVICES_BATCH_REPORT_PICTURES_H_

#include <map>
#include <memory>
#include <string>

#include "common/core/frame_id.h"
#include "services/batch/frame_lookup.h"
#include "services/batch/manifest.h"

namespace sprout::batch {

/// The pictures of single frames for the report, from the logs and the results of their shards.
class ReportPictures {
 public:
  ReportPictures(const BatchFolder& folder, const Manifest& manifest)
      : folder_(folder), manifest_(manifest) {}

  /// Left image, the map of each variant on one scale, and where they differ, side by side, as HTML
  /// with the pictures in it; a line that says why when the log or a result cannot be read.
  std::string HtmlOf(size_t shard, int64_t seq, int64_t utime);

 private:
  FrameLookup& ResultOf(size_t variant, size_t shard);
  cv::Mat LeftOf(size_t shard, const FrameId& id) const;

  const BatchFolder& folder_;
  const Manifest& manifest_;
  std::map<std::pair<size_t, size_t>, std::unique_ptr<FrameLookup>> results_;  // variant, shard
};

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_REPORT_PICTURES_H_
