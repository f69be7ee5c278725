// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
#include "services/prior/edges/plane_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/prior/edges/plane_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sprout::prior {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr int kIterations = 3;  // of reweighting; more make noisy seeds worse
// The first plane is level, and a slant must not look like another surface: its scale is wider.
constexpr double kFirstScale = 1.5;

using D = hn::CappedTag<double, PlaneFits::kAtOnce>;
using V = hn::Vec<D>;
using DFloat = hn::Rebind<float, D>;

HWY_INLINE V Square(V x) { return hn::Mul(x, x); }

// The Geman-McClure M-estimator: weight of a residual, ρ'(r) / r up to a factor.
HWY_INLINE V SupportWeight(V residual, V scale) {
  const V one = hn::Set(D(), 1.0);
  return hn::Div(one, Square(hn::Add(one, Square(hn::Div(residual, scale)))));
}

// Planes at their seeds, some lanes of PlaneFits. Kept in single precision, as Plane has them.
struct Planes {
  hn::Vec<DFloat> disparity, per_column, per_row;

  // Plane::At() less the plane's own position. @param across, down  exact in double precision.
  HWY_INLINE V At(V across, V down) const {
    const DFloat d;
    const auto along_row = hn::Mul(per_column, hn::DemoteTo(d, across));
    const auto along_column = hn::Mul(per_row, hn::DemoteTo(d, down));
    return hn::PromoteTo(D(), hn::Add(hn::Add(disparity, along_row), along_column));
  }
};

// Weighted least squares for planes, with a weight for level slopes.
class NormalEquations {
 public:
  HWY_INLINE explicit NormalEquations(double slope_weight)
      : n_(hn::Zero(D())),
        x_(n_),
        y_(n_),
        xx_(hn::Set(D(), slope_weight)),
        xy_(n_),
        yy_(xx_),
        d_(n_),
        dx_(n_),
        dy_(n_) {}

  // x, y: columns and rows from the plane's position.
  HWY_INLINE void Add(V weight, V x, V y, V d) {
    const V weighted_x = hn::Mul(weight, x);
    const V weighted_y = hn::Mul(weight, y);
    n_ = hn::Add(n_, weight);
    x_ = hn::Add(x_, weighted_x);
    y_ = hn::Add(y_, weighted_y);
    xx_ = hn::Add(xx_, hn::Mul(weighted_x, x));
    xy_ = hn::Add(xy_, hn::Mul(weighted_x, y));
    yy_ = hn::Add(yy_, hn::Mul(weighted_y, y));
    d_ = hn::Add(d_, hn::Mul(weight, d));
    dx_ = hn::Add(dx_, hn::Mul(weighted_x, d));
    dy_ = hn::Add(dy_, hn::Mul(weighted_y, d));
  }

  // Solves for the disparity first, with the slopes eliminated.
  HWY_INLINE Planes Solve() const {
    const DFloat d;
    const auto minor = [](V a, V b, V c, V e)
                           HWY_ATTR { return hn::Sub(hn::Mul(a, b), hn::Mul(c, e)); };
    const V determinant = minor(xx_, yy_, xy_, xy_);
    const V p = hn::Div(minor(yy_, x_, xy_, y_), determinant);
    const V q = hn::Div(minor(xx_, y_, xy_, x_), determinant);
    const V right = hn::Sub(hn::Sub(d_, hn::Mul(p, dx_)), hn::Mul(q, dy_));
    const V left = hn::Sub(hn::Sub(n_, hn::Mul(p, x_)), hn::Mul(q, y_));
    const V disparity = hn::Div(right, left);
    const V right_x = hn::Sub(dx_, hn::Mul(x_, disparity));
    const V right_y = hn::Sub(dy_, hn::Mul(y_, disparity));
    return {hn::DemoteTo(d, disparity),
            hn::DemoteTo(d, hn::Div(minor(yy_, right_x, xy_, right_y), determinant)),
            hn::DemoteTo(d, hn::Div(minor(xx_, right_y, xy_, right_x), determinant))};
  }

 private:
  V n_, x_, y_, xx_, xy_, yy_, d_, dx_, dy_;
};

// The least-squares planes whose support weighs by its residuals to `planes`.
HWY_INLINE Planes Refit(const Planes& planes, const PlaneFits& fits, size_t lane, V scale,
                        double slope_weight) {
  const D d;
  NormalEquations equations(slope_weight);
  for (size_t j = 0; j < fits.most_support; ++j) {
    const auto load = [&](const PlaneFits::Numbers& numbers)
                          HWY_ATTR { return hn::LoadU(d, &numbers[lane]); };
    const V x = load(fits.across[j]);
    const V y = load(fits.down[j]);
    const V disparity = load(fits.disparity[j]);
    const V weight = SupportWeight(hn::Sub(disparity, planes.At(x, y)), scale);
    equations.Add(hn::Mul(weight, load(fits.weight[j])), x, y, disparity);
  }
  return equations.Solve();
}

}  // namespace

void FitOnTarget(double slope_weight, PlaneFits& fits) {
  const D d;
  const DFloat df;
  constexpr size_t kLanes = hn::MaxLanes(d);
  for (size_t lane = 0; lane < PlaneFits::kAtOnce; lane += kLanes) {
    float disparity[kLanes], per_column[kLanes], per_row[kLanes];
    for (size_t i = 0; i < kLanes; ++i) disparity[i] = fits.planes[lane + i].disparity;
    const Planes level{hn::LoadU(df, disparity), hn::Zero(df), hn::Zero(df)};
    const V scale = hn::LoadU(d, &fits.scale_px[lane]);
    Planes planes = Refit(level, fits, lane, hn::Mul(hn::Set(d, kFirstScale), scale), slope_weight);
    for (int i = 1; i < kIterations; ++i) planes = Refit(planes, fits, lane, scale, slope_weight);
    const V near = hn::LoadU(d, &fits.near_px[lane]);
    const Planes nearest = Refit(level, fits, lane, near, slope_weight);
    hn::StoreU(planes.disparity, df, disparity);
    hn::StoreU(planes.per_column, df, per_column);
    hn::StoreU(planes.per_row, df, per_row);
    float near_disparity[kLanes];
    hn::StoreU(nearest.disparity, df, near_disparity);
    for (size_t i = 0; i < kLanes; ++i) {
      Plane& plane = fits.planes[lane + i];
      plane.disparity = fits.near_px[lane + i] > 0 ? near_disparity[i] : disparity[i];
      plane.per_column = per_column[i];
      plane.per_row = per_row[i];
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::prior
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout::prior {

HWY_EXPORT(FitOnTarget);

void FitPlanesAtOnce(double slope_weight, PlaneFits& fits) {
  HWY_DYNAMIC_DISPATCH(FitOnTarget)(slope_weight, fits);
}

}  // namespace sprout::prior
#endif  // HWY_ONCE
