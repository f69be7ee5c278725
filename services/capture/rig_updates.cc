#include "services/capture/rig_updates.h"

#include <exception>
#include <utility>

#include "common/app/low_priority.h"
#include "common/bus/channels.h"
#include "common/messages/codec.h"

namespace sprout::capture {
namespace {

std::shared_ptr<CurrentRig> Required(std::shared_ptr<CurrentRig> current,
                                     const CaptureConfig& config) {
  if (current) return current;
  throw ConfigError("self_calibrate.mode = APPLY: capture.source = " + config.source() +
                    " is not rectified here; allowed: genicam:, opencv:, v4l2: and log: with "
                    "?rig=FILE, without --raw");
}

}  // namespace

RigUpdates::RigUpdates(const ServiceContext& context, std::shared_ptr<CurrentRig> current,
                       StageMonitor& monitor)
    : monitor_(monitor),
      keeper_(context.config.self_calibrate(),
              Required(std::move(current), context.config.capture())),
      worker_([this](const std::stop_token& stop) { Work(stop); }),
      receiver_(
          context.lcm_url, context.prefix, {kRigChangeChannel},
          [this](std::string_view, std::span<const uint8_t> bytes) { OnMessage(bytes); },
          [this](std::string_view channel) { monitor_.MessageDropped(channel); }) {}

void RigUpdates::OnMessage(std::span<const uint8_t> bytes) {
  Result<RigChange> change = DecodeRigChange(bytes);
  if (!change) return monitor_.BadMessage(kRigChangeChannel, change.error().text);
  changes_.Put(*std::move(change));
}

void RigUpdates::Work(const std::stop_token& stop) {
  LowerPriority();
  while (const std::optional<RigChange> change = changes_.Take(stop)) {
    try {
      const RigKeeper::Outcome outcome = keeper_.Consider(*change, RigKeeper::Clock::now());
      if (!outcome.text.empty()) monitor_.Warn(outcome.text);
    } catch (const std::exception& e) {  // out of memory
      monitor_.Failure(std::string("the calibration is not changed: ") + e.what());
    }
  }
}

}  // namespace sprout::capture
