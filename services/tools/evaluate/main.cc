#include <functional>
#include <iostream>
#include <string>

#include "services/tools/evaluate/program.h"
#include "services/tools/log/log_frames.h"

namespace sprout::evaluate {
namespace {

void ReadFrames(const LogChoice& log, const std::function<void(const Frame&)>& visit) {
  const std::string complaint =
      log::ReadFrames({.file = log.file, .folder = {}, .frames = log.frames, .prefix = log.prefix},
                      AllParts(), visit);
  if (!complaint.empty()) std::cerr << "sprout-evaluate: " << complaint << "\n";
}

}  // namespace
}  // namespace sprout::evaluate

int main(int argc, char** argv) {
  return sprout::evaluate::EvaluateMain(argc, argv, sprout::evaluate::ReadFrames);
}
