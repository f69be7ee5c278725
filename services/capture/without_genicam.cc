// Takes the place of genicam/ in a build without it.
#include "common/config/left_out.h"
#include "services/capture/genicam/genicam_source.h"

namespace sprout::capture {

std::unique_ptr<RawSource> OpenGenicam(const RigDescription&, const std::string& path,
                                       scenes::Waiting) {
  throw LeftOut("capture.source = genicam:" + path, "GENICAM");
}

std::string ListCameras() { throw LeftOut("--list", "GENICAM"); }

}  // namespace sprout::capture
