#include <utility>

#include "common/scenes/dataset.h"

namespace sprout::scenes {
namespace {

class DatasetPlayer : public FrameSource {
 public:
  DatasetPlayer(std::unique_ptr<Dataset> dataset, bool loop)
      : dataset_(std::move(dataset)), loop_(loop) {}

  const Rig& rig() const override { return dataset_->rig(); }
  bool is_live() const override { return false; }

  std::optional<CapturedFrame> Next(const std::stop_token& stop) override {
    const std::optional<int64_t> count = dataset_->frame_count();
    if (stop.stop_requested() || (count && next_ >= *count && !loop_)) return std::nullopt;
    const int64_t index = next_++;
    return dataset_->Get(count ? index % *count : index);
  }

 private:
  std::unique_ptr<Dataset> dataset_;
  bool loop_;
  int64_t next_ = 0;
};

}  // namespace

std::unique_ptr<FrameSource> PlayDataset(std::unique_ptr<Dataset> dataset, bool loop) {
  return std::make_unique<DatasetPlayer>(std::move(dataset), loop);
}

}  // namespace sprout::scenes
