#include "services/capture/source_feed.h"

#include <algorithm>

#include "common/core/image.h"
#include "common/messages/codec.h"
#include "services/capture/dataset.h"

namespace sprout {
namespace {

class SourceFeed : public CaptureFeed {
 public:
  SourceFeed(const CaptureConfig& config, bool loop)
      : config_(config), source_(OpenDataset(config)), loop_(loop) {
    newest_.rig_id = RigId(source_->rig());
  }

  std::optional<CaptureMessages> Next() override {
    const int64_t seq = newest_.seq + 1;
    const std::optional<int64_t> count = source_->frame_count();
    if (count && seq >= *count && !loop_) return std::nullopt;
    const DatasetFrame frame = source_->Get(count ? seq % *count : seq);
    // Captures are told apart by their time even when the clock is set back.
    newest_.utime = std::max(NowUtime(), newest_.utime + 1);
    newest_.seq = seq;
    CaptureMessages messages{.id = newest_, .messages = {}};
    const auto add = [&](Part part, const PartValue& value) {
      messages.messages.emplace_back(
          part, EncodePart(newest_, part, value, DisparityEncoding::kRawInt16));
    };
    add(Part::kLeft, config_.left_in_colour() ? frame.left : cv::Mat(ToGrey(frame.left)));
    add(Part::kRight, config_.right_in_colour() ? frame.right : cv::Mat(ToGrey(frame.right)));
    add(Part::kTof, frame.tof);
    return messages;
  }

  std::vector<uint8_t> Calibration() const override {
    const FrameId id{newest_.utime, std::max<int64_t>(newest_.seq, 0), newest_.rig_id};
    return EncodePart(id, Part::kRig, source_->rig(), DisparityEncoding::kRawInt16);
  }

  bool is_recorded() const override { return false; }

 private:
  CaptureConfig config_;
  std::unique_ptr<Dataset> source_;
  bool loop_;
  FrameId newest_;
};

}  // namespace

std::unique_ptr<CaptureFeed> OpenSourceFeed(const CaptureConfig& config, bool loop) {
  return std::make_unique<SourceFeed>(config, loop);
}

}  // namespace sprout
