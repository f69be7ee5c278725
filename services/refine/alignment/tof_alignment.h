#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/geometry/projection.h"
#include "services/refine/alignment/alignment_rules.h"
#include "services/refine/alignment/tof_edges.h"

namespace sprout::refine {

/// How far EdgeProfiles looks, px of the images.
struct ProfileSizes {
  int reach = 0;        ///< farthest place on either side of where an edge should be; > 0
  int window = 0;       ///< pixels on either side of a place that are averaged; > 0
  double plane_px = 0;  ///< how far surfaces are extrapolated with their slopes
};

/// Where a pair of images shows depth edges: for each edge and each place along its normal the
/// evidence, eq. (A4), that the edge lies there. Keeps its memory, 4 bytes a place of an edge.
class EdgeProfiles {
 public:
  /// @param left, right  rectified pair, grey, of one size.
  /// @param edges        in px of these images, inside the left one.
  /// O(edges · (reach + window)), about 20 ns each. On OpenCV's threads, with the same result for
  /// any number.
  void Set(const cv::Mat1b& left, const cv::Mat1b& right, std::span<const TofEdge> edges,
           const ProfileSizes& sizes);

  /// Evidence that edge `k` lies `place` px along its normal, rounded: up to 1.5; 0 beyond the
  /// reach.
  float At(size_t k, double place) const {
    return std::abs(place) <= reach_ ? Value(k, cvRound(place)) : 0;
  }

  /// The evidence of At() between the pixels, linear.
  double Between(size_t k, double place) const;

 private:
  float Value(size_t k, int place) const {
    if (place > reach_) return 0;
    return profiles_[k * places_ + static_cast<size_t>(place + reach_)];
  }

  int reach_ = 0;
  size_t places_ = 0;
  std::vector<float> profiles_;
};

/// How far off the points of a ToF camera are projected, as measured in the images. The model is a
/// rotation of the ToF camera about its own centre, not about its optical axis: it shifts all
/// points by nearly the same offset, whatever their depth.
struct TofOffset {
  double du_px = 0;  ///< what has to be added in the middle of the left image, px
  double dv_px = 0;
  /// Standard deviations, px, from chance and from what makes all edges on one side of objects look
  /// shifted. Infinite when nothing was found.
  double sigma_u_px = std::numeric_limits<double>::infinity();
  double sigma_v_px = std::numeric_limits<double>::infinity();
  double significance = 0;  ///< length of the offset in standard deviations
  int edges = 0;            ///< depth edges that it rests on
  /// Whether the offset can be believed within its standard deviations: enough edges, one clear
  /// best offset, standard deviations below a quarter of a ToF pixel.
  bool sure = false;

  /// Whether the calibration of the ToF camera is wrong without doubt.
  bool IsOff() const { return sure && significance >= AlignmentRules::kSignificant; }

  bool operator==(const TofOffset&) const = default;
};

/// Measures in one frame how far the calibration of the ToF camera is off: searches the images for
/// the ends of surfaces that the ToF camera saw. A pure function of the frame; keeps only its
/// memory, so one object serves one caller at a time.
class TofAligner {
 public:
  /// Looks for offsets of up to two ToF pixels across and down.
  /// @param left, right  rectified pair of the calibrated size, grey.
  /// @param points       of `tof`, projected, after RangeUnwrapper.
  /// @param tof          range image of the calibrated size.
  /// O(ToF pixels + image pixels): about 1 ms and 3 µs a depth edge at 2 MP. No I/O; on OpenCV's
  /// threads, with the same result for any number.
  TofOffset Estimate(const cv::Mat1b& left, const cv::Mat1b& right,
                     std::span<const ProjectedPoint> points, const TofImage& tof,
                     const TofProjector& projector);

 private:
  struct Votes;
  struct Fit;

  Votes Vote(int most_px, double cell_px) const;
  Fit Maximise(Eigen::Vector2d start, double step_px) const;
  void FindErrors(double step_px, double cell_px, Fit& fit) const;

  TofEdgeFinder finder_;
  std::vector<TofEdge> edges_;  // in px of the images that are looked at
  EdgeProfiles profiles_;
};

/// Rotates the ToF camera about its own centre such that its points move by the offset.
void ApplyOffset(const TofOffset& offset, const Rig& rig, std::vector<ProjectedPoint>& points);

}  // namespace sprout::refine
