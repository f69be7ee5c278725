#include "services/capture/raw_source.h"

#include <utility>

#include "common/core/image.h"

namespace sprout::capture {
namespace {

Result<void> CheckSize(const std::string& what, cv::Size size, cv::Size calibrated) {
  if (size == calibrated) return {};
  return Fail(what + " of " + SizeText(size) + ": allowed is the calibrated size " +
              SizeText(calibrated));
}

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
      std::optional<scenes::CapturedFrame> raw = cameras_->Next(stop);
      if (!raw) return AtEnd();
      lost_.count += raw->lost;
      if (!raw->trouble.empty()) lost_.trouble = raw->trouble;
      const RigInUsePtr rig = current_->Get();
      Result<scenes::CapturedFrame> frame = RectifyFrame(rig->rectifier, std::move(*raw));
      if (frame) {
        if (rig != used_) frame->new_rig = rig->named();
        used_ = rig;
        frame->lost = lost_.count;
        frame->trouble = lost_.trouble;
        return std::move(*frame);
      }
      ++lost_.count;
      lost_.trouble = frame.error().text;
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

Result<scenes::CapturedFrame> RectifyFrame(const Rectifier& rectifier, scenes::CapturedFrame raw) {
  const RawRig& rig = rectifier.raw();
  Result<void> fits = CheckSize("left image", raw.left.size(), rig.left.size());
  if (fits) fits = CheckSize("right image", raw.right.size(), rig.right.size());
  if (fits && !raw.tof.depth_m.empty()) {
    fits = CheckSize("ToF image", raw.tof.depth_m.size(), rig.tof.size());
  }
  if (!fits) return tl::unexpected<Error>(fits.error());
  raw.left = rectifier.RectifyLeft(raw.left);
  raw.right = rectifier.RectifyRight(raw.right);
  rectifier.CorrectRanges(raw.tof);
  return raw;
}

std::unique_ptr<scenes::FrameSource> Rectified(std::unique_ptr<RawSource> cameras,
                                               std::shared_ptr<CurrentRig> rig) {
  return std::make_unique<RectifiedSource>(std::move(cameras), std::move(rig));
}

}  // namespace sprout::capture
