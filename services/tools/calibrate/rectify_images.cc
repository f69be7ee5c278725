#include "services/tools/calibrate/rectify_images.h"

#include "common/core/image.h"
#include "common/geometry/projection.h"

namespace sprout::calibrate {

Result<RigImages> RectifyImages(const Rectifier& rectifier, const RigImages& images) {
  const cv::Size size = rectifier.raw().left.size();
  if (images.left.size() != size || images.right.size() != size) {
    return Fail("images of " + SizeText(images.left.size()) + " and " +
                SizeText(images.right.size()) + ": allowed is the calibrated size " +
                SizeText(size));
  }
  TofImage tof = images.tof;
  if (const auto fits = CheckTofSize(RigOfFrame(rectifier.rig(), tof), tof); !fits) {
    return tl::unexpected(fits.error());
  }
  rectifier.CorrectRanges(tof);
  return RigImages{.left = rectifier.RectifyLeft(images.left),
                   .right = rectifier.RectifyRight(images.right),
                   .tof = tof};
}

}  // namespace sprout::calibrate
