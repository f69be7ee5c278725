#ifndef SPROUT_SERVICES_CAPTURE_SOURCE_FEED_H_
#define SPROUT_SERVICES_CAPTURE_SOURCE_FEED_H_

#include <memory>

#include "services/capture/capture_feed.h"

namespace sprout {

/// Frames of a Dataset, numbered from 0 and stamped with the time at which they are taken: the
/// only place where a clock enters a payload.
/// @throws ConfigError, see OpenDataset().
std::unique_ptr<CaptureFeed> OpenSourceFeed(const CaptureConfig& config, bool loop);

}  // namespace sprout

#endif  // SPROUT_SERVICES_CAPTURE_SOURCE_FEED_H_
