#include "services/batch/frame_commands.h"

#include <fmt/format.h>

#include <vector>

#include "common/core/shell_word.h"

namespace sprout::batch {
namespace {

std::string CommandLine(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : " ") + ShellWord(word);
  return line + "\n";
}

}  // namespace

std::string FrameCommands(const BatchFolder& folder, const BatchHead& head, const BatchLog& log,
                          int64_t seq, const std::filesystem::path& programs) {
  std::vector<std::string> last;
  if (!head.prefix.empty()) last.push_back("--channel-prefix=" + head.prefix);  // may begin with -
  const auto line = [&](std::vector<std::string> words) {
    words.insert(words.end(), last.begin(), last.end());
    return CommandLine(words);
  };
  const std::string frame = std::to_string(seq);
  std::string text =
      line({(programs / "sprout-view").string(), "--log", log.path, "--frame", frame});
  for (const Variant& variant : head.variants) {
    std::vector<std::string> replays = {"--replay", log.path};
    for (const std::string& stage : head.stages) {
      const std::string record = fmt::format("{}_{}.lcm", stage, variant.name);
      std::vector<std::string> words = {variant.programs.at(stage).path, "--config",
                                        folder.config(variant.name).string(), "--frames", frame};
      words.insert(words.end(), replays.begin(), replays.end());
      words.insert(words.end(), {"--record", record});
      text += line(std::move(words));
      replays.insert(replays.end(), {"--replay", record});
    }
  }
  return text;
}

}  // namespace sprout::batch
