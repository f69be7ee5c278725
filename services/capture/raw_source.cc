#include "services/capture/raw_source.h"

#include <utility>

namespace sprout::capture {
namespace {

class RectifiedSource : public scenes::FrameSource {
 public:
  RectifiedSource(std::unique_ptr<RawSource> cameras, std::shared_ptr<CurrentRig> rig)
      : cameras_(std::move(cameras)),
        current_(std::move(rig)),
        first_(current_->Get()),
        used_(first_) {}

  const Rig& rig() const override { return first_->rectifier.rig(); }
  bool is_live() const override { return cameras_->is_live(); }

  std::optional<scenes::CapturedFrame> Next(const std::stop_token& stop) override {
    lost_ = {};
    while (true) {
      std::optional<scenes::CapturedFrame> frame = cameras_->Next(stop);
      if (!frame) return AtEnd();
      lost_.count += frame->lost;
      if (!frame->trouble.empty()) lost_.trouble = frame->trouble;
      const RigInUsePtr rig = current_->Get();
      const Result<void> rectified = rig->rectifier.Rectify(frame->left, frame->right, frame->tof);
      if (rectified) {
        if (rig != used_) frame->new_rig = rig->named();
        used_ = rig;
        frame->lost = lost_.count;
        frame->trouble = lost_.trouble;
        return frame;
      }
      ++lost_.count;
      lost_.trouble = rectified.error().text;
    }
  }

  scenes::LostFrames lost_at_end() const override { return lost_; }

 private:
  std::optional<scenes::CapturedFrame> AtEnd() {
    const scenes::LostFrames of_cameras = cameras_->lost_at_end();
    lost_.count += of_cameras.count;
    if (!of_cameras.trouble.empty()) lost_.trouble = of_cameras.trouble;
    return std::nullopt;
  }

  std::unique_ptr<RawSource> cameras_;
  std::shared_ptr<CurrentRig> current_;
  RigInUsePtr first_;
  RigInUsePtr used_;         // for the newest frame
  scenes::LostFrames lost_;  // since the newest frame
};

}  // namespace

std::unique_ptr<scenes::FrameSource> Rectified(std::unique_ptr<RawSource> cameras,
                                               std::shared_ptr<CurrentRig> rig) {
  return std::make_unique<RectifiedSource>(std::move(cameras), std::move(rig));
}

}  // namespace sprout::capture
