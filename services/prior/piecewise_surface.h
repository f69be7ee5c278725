#ifndef SPROUT_SERVICES_PRIOR_PIECEWISE_SURFACE_H_
#define SPROUT_SERVICES_PRIOR_PIECEWISE_SURFACE_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <span>

#include "services/prior/seed_surface.h"

namespace sprout {

/// The part in a triangle of the surface that some seeds lie on: at each place the plane of the
/// closest of them. Places are relative to an origin near the triangle, px: squares of positions in
/// the image have more digits than a float.
class PiecewiseSurface {
 public:
  using Corners = std::array<cv::Point2f, 3>;

  void Clear() { count_ = 0; }

  /// Adds a seed, unless one before it is closer all over the triangle, or there are eight.
  /// @param place    of the seed.
  /// @param corners  places of the triangle's corners.
  void Add(const LocalPlane& plane, cv::Point2f place, const Corners& corners) {
    const Piece piece{{plane.disparity - plane.per_column * place.x - plane.per_row * place.y,
                       plane.per_column, plane.per_row},
                      {place.dot(place), -2 * place.x, -2 * place.y}};
    if (count_ == pieces_.size() || IsHidden(piece, corners)) return;
    pieces_[count_++] = piece;
  }

  /// Disparity at a place, px. There must be a seed.
  float At(cv::Point2f place) const {
    const Piece* closest = pieces_.data();
    float least = closest->distance.At(place);
    for (const Piece& piece : pieces().subspan(1)) {
      const float distance = piece.distance.At(place);
      if (distance >= least) continue;
      least = distance;
      closest = &piece;
    }
    return closest->disparity.At(place);
  }

  /// The most that planes of two surfaces are apart at a corner, and so in the triangle, px.
  float GapPx(const PiecewiseSurface& other, const Corners& corners) const {
    float gap = 0;
    for (const Piece& a : pieces()) {
      for (const Piece& b : other.pieces()) {
        for (cv::Point2f corner : corners) {
          gap = std::max(gap, std::abs(a.disparity.At(corner) - b.disparity.At(corner)));
        }
      }
    }
    return gap;
  }

 private:
  // A number that changes linearly over the image.
  struct Linear {
    float at_origin;
    float per_column;
    float per_row;

    float At(cv::Point2f place) const {
      return at_origin + per_column * place.x + per_row * place.y;
    }
  };

  struct Piece {
    Linear disparity;  // px
    Linear distance;   // from the seed, squared, less the square of the place, px²
  };

  std::span<const Piece> pieces() const { return std::span(pieces_).first(count_); }

  // Differences of distances are linear: what is closer at the corners is so in between.
  bool IsHidden(const Piece& piece, const Corners& corners) const {
    return std::any_of(pieces().begin(), pieces().end(), [&](const Piece& other) {
      return std::all_of(corners.begin(), corners.end(), [&](cv::Point2f corner) {
        return other.distance.At(corner) <= piece.distance.At(corner);
      });
    });
  }

  std::array<Piece, 8> pieces_;  // two are usual
  size_t count_ = 0;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_PIECEWISE_SURFACE_H_
