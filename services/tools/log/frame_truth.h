#ifndef SPROUT_SERVICES_TOOLS_LOG_FRAME_TRUTH_H_
#define SPROUT_SERVICES_TOOLS_LOG_FRAME_TRUTH_H_

#include <array>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "common/core/frame.h"
#include "common/picture/frame_pictures.h"
#include "common/scenes/dataset.h"

namespace sprout::log {

/// Ground truth for the frames of a log that capture sent from a scene, and the accuracy of their
/// maps.
class LogTruth {
 public:
  /// @param source  capture's, such as "middlebury:DIR"; empty: no truth.
  /// @throws ConfigError when it cannot be opened.
  explicit LogTruth(const std::string& source);
  ~LogTruth();

  /// Records the frame's seeds and scores its maps.
  /// @returns the truth of frame `seq`: if capture repeated the scene, of its frame `seq` modulo
  ///          the number of frames. Empty without a source.
  /// @throws ConfigError when a map of the frame has another size.
  const FrameTruth& Add(const Frame& frame);

  /// Text for people: the newest frame's seeds by refinement rule, and a table of each map's
  /// density and, with a source, share of correct pixels (≤ 1 px, of those that both cameras see),
  /// as means over the frames. Empty without seeds and maps.
  std::string Text() const;

 private:
  struct MapSum {
    int64_t frames = 0;
    double density_percent = 0;
    double correct_percent = 0;
  };

  void AddMap(MapSum& sum, const DisparityImage& map);
  void Load(int64_t seq);

  std::string source_;
  std::unique_ptr<scenes::Dataset> dataset_;
  std::optional<int64_t> loaded_;  // the frame of the dataset in truth_
  FrameTruth truth_;
  std::array<MapSum, 3> maps_;  // in the order of kMapNames
  std::optional<SeedSet> newest_seeds_;
  int64_t newest_seq_ = 0;
};

}  // namespace sprout::log

#endif  // SPROUT_SERVICES_TOOLS_LOG_FRAME_TRUTH_H_
