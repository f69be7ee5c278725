#include <functional>
#include <iostream>
#include <string>

#include "common/config/config.h"
#include "common/logfile/log_error.h"
#include "services/evaluate/program.h"
#include "services/log/log_frames.h"

namespace sprout::evaluate {
namespace {

void ReadFrames(const LogChoice& log, const std::function<void(const Frame&)>& visit) {
  try {
    log::LogFrames frames(
        {.file = log.file, .folder = {}, .frames = log.frames, .prefix = log.prefix}, AllParts(),
        visit);
    frames.Read();
    if (const std::string complaint = frames.Complaint(); !complaint.empty()) {
      std::cerr << "sprout-evaluate: " << complaint << "\n";
    }
  } catch (const LogError& e) {
    throw ConfigError(std::string("--log ") + e.what());
  }
}

}  // namespace
}  // namespace sprout::evaluate

int main(int argc, char** argv) {
  return sprout::evaluate::EvaluateMain(argc, argv, sprout::evaluate::ReadFrames);
}
