#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "common/rig/rectifier.h"
#include "common/rig/rig_file.h"
#include "common/scenes/frame_source.h"

namespace sprout::capture {

/// A calibration in use.
struct RigInUse {
  Rectifier rectifier;
  std::string rig_id;  ///< of the frames that it rectifies

  scenes::NamedRig named() const { return {rectifier.rig(), rig_id}; }
};
using RigInUsePtr = std::shared_ptr<const RigInUse>;

/// The calibration that the next frame is rectified with. Sources take it once a frame, so that it
/// never changes within one. Thread-safe.
class CurrentRig {
 public:
  /// @param file  with a calibration; `path` is where it was read.
  /// @throws ConfigError when it cannot be used.
  CurrentRig(RigDescription file, std::filesystem::path path)
      : file_(std::move(file)), path_(std::move(path)) {
    Rectifier rectifier(RequireCalibration(file_, path_));
    std::string rig_id = RigId(rectifier.rig());
    newest_ = std::make_shared<const RigInUse>(RigInUse{std::move(rectifier), std::move(rig_id)});
  }

  /// The rig file that capture started with.
  const RigDescription& file() const { return file_; }
  const std::filesystem::path& path() const { return path_; }

  RigInUsePtr Get() const {
    const std::lock_guard lock(mutex_);
    return newest_;
  }

  void Replace(RigInUsePtr rig) {
    const std::lock_guard lock(mutex_);
    newest_ = std::move(rig);
  }

 private:
  RigDescription file_;
  std::filesystem::path path_;
  mutable std::mutex mutex_;
  RigInUsePtr newest_;
};

}  // namespace sprout::capture
