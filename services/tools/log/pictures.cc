// sprout-log images: the frames of a log as pictures.
#include <iostream>
#include <string>

#include "common/picture/frame_pictures.h"
#include "services/tools/log/commands.h"
#include "services/tools/log/frame_truth.h"
#include "services/tools/log/log_frames.h"

namespace sprout::log {

int RunImages(const ImagesOptions& options) {
  LogTruth truth(options.truth);
  FrameFileNames names(options.folder);
  const std::string complaint = ReadFrames(options, AllParts(), [&](const Frame& frame) {
    WriteFramePictures(frame, truth.Add(frame), names.For(frame.id));
  });
  FinishFiles(complaint, names, options, "no message of these frames that can be shown");
  std::cout << truth.Text();
  return 0;
}

}  // namespace sprout::log
