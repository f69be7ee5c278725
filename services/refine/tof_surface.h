#ifndef SPROUT_SERVICES_REFINE_TOF_SURFACE_H_
#define SPROUT_SERVICES_REFINE_TOF_SURFACE_H_

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/geometry/projection.h"

namespace sprout {

/// The surface that a ToF image shows, as disparities (px) at the ToF pixels, and two tests of its
/// points against it. Each looks at the neighbours of a point only.
class TofSurface {
 public:
  /// Fewest of a pixel's eight neighbours that must lie on its surface.
  static constexpr int kSupport = 2;

  /// @param points  of one ToF image, at most one a pixel.
  TofSurface(const Rig& rig, std::span<const ProjectedPoint> points);

  /// Which points hang loose: fewer than two of the eight neighbours in the ToF image have a
  /// disparity within `tolerance_px`. Flying pixels, whose light comes from two surfaces so that
  /// they lie on neither, and outliers of the noise. Two neighbours are enough for a slant or a
  /// thin thing: along a line of equal depth there are two.
  /// @param points  some of those that this was made of.
  /// @returns one flag a point. O(points).
  std::vector<bool> FindLoose(std::span<const ProjectedPoint> points, double tolerance_px) const;

  /// Which points a nearer surface hides from the left or from the right camera: what the ToF
  /// camera sees past an edge from its own place. Each point stands for the piece of surface up to
  /// `reach` ToF pixels from it on all sides in the image, with the slant that its neighbours show;
  /// a point further than such a piece by more than `tolerance_px` is hidden.
  ///
  /// The idea of the paper's background rule, whose window of 5×5 px is too small for a sensor
  /// with fewer pixels: here the window grows with the distance of the seeds, and the slant is
  /// taken off, since over such a distance a slant is no edge.
  /// @param points  those that are tested and that hide; some of those that this was made of, all
  ///                inside the images.
  /// @param reach   > 0. Below 1 a piece ends before the next ToF pixel of a surface.
  /// @returns one flag a point. Does not depend on their order.
  /// O(points + image pixels / 25) for points that are spread as a sensor's.
  std::vector<bool> FindHidden(std::span<const ProjectedPoint> points, double reach,
                               double tolerance_px) const;

 private:
  // Change of disparity from one ToF pixel to the next, px.
  struct Slant {
    float across = 0;
    float down = 0;
  };

  float At(int tof_u, int tof_v) const;
  Slant SlantAt(const ProjectedPoint& point) const;

  cv::Size size_;     // of the images of the pair
  double column_px_;  // distance of ToF columns in the images of the pair, px
  double row_px_;
  cv::Mat1f disparity_;  // of the ToF pixels, NaN = none
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_REFINE_TOF_SURFACE_H_
