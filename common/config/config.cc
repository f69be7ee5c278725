#include "common/config/config.h"

#include <dlfcn.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>
#include <link.h>

#include <algorithm>
#include <sstream>

#include "common/core/input_files.h"
#include "common/core/joined.h"
#include "common/core/read_text.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using google::protobuf::TextFormat;

// Keeps the first complaint of the parser.
class FirstError : public google::protobuf::io::ErrorCollector {
 public:
  void AddError(int line, google::protobuf::io::ColumnNumber column,
                const std::string& message) override {
    if (!text.empty()) return;
    text = std::to_string(line + 1) + ":" + std::to_string(column + 1) + ": " + message;
  }

  std::string text;
};

double NumberIn(const Message& message, const FieldDescriptor& field) {
  const Reflection& reflection = *message.GetReflection();
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return reflection.GetDouble(message, &field);
    case FieldDescriptor::CPPTYPE_INT32:
      return reflection.GetInt32(message, &field);
    default:
      throw std::logic_error("range on a field that is neither double nor int32: " +
                             field.full_name());
  }
}

// Sets every field to what it reads as, so that the text shows defaults too.
void MakeDefaultsExplicit(Message& message) {
  const Reflection& reflection = *message.GetReflection();
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor* field = message.GetDescriptor()->field(i);
    if (field->is_repeated()) continue;  // a list has no default, and shows what it has
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      MakeDefaultsExplicit(*reflection.MutableMessage(&message, field));
    } else if (!reflection.HasField(message, field)) {
      std::string value;
      TextFormat::PrintFieldValueToString(message, field, -1, &value);
      TextFormat::ParseFieldValueFromString(value, field, &message);
    }
  }
}

// The program or the shared library that this code is in.
fs::path ThisModule() {
  Dl_info info{};
  link_map* map = nullptr;
  const bool in_library = dladdr1(reinterpret_cast<const void*>(&ThisModule), &info,
                                  reinterpret_cast<void**>(&map), RTLD_DL_LINKMAP) != 0 &&
                          map->l_name[0] != '\0';
  std::error_code ignored;
  return fs::canonical(in_library ? map->l_name : "/proc/self/exe", ignored);
}

std::string PathOf(const std::string& file) {
  if (file.find_first_of("/.") != std::string::npos) return file;
  return (PresetsFolder() / (file + ".textproto")).string();
}

std::string PresetNames() {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(PresetsFolder(), ignored)) {
    if (entry.path().extension() == ".textproto") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return Joined(", ", names);
}

void MergeFile(const std::string& file, SproutConfig& config) {
  SproutConfig parsed;  // apart: a key that stands twice in one file is an error
  if (file.find('{') != std::string::npos) {
    ParseText(file, "configuration text", parsed);
  } else {
    ParseTextFile(PathOf(file), "configuration", "a file, or a preset (" + PresetNames() + ")",
                  parsed);
  }
  config.MergeFrom(parsed);
}

}  // namespace

void ParseTextFile(const fs::path& path, const std::string& what, const std::string& allowed,
                   Message& message) {
  NoteInputFile(path);
  const Result<std::string> text = ReadText(path);
  if (!text) {
    throw ConfigError(what + " " + path.string() + ": " + text.error().text +
                      "; allowed: " + allowed);
  }
  ParseText(*text, what + " " + path.string(), message);
}

void ParseText(const std::string& text, const std::string& name, Message& message) {
  FirstError error;
  TextFormat::Parser parser;
  parser.RecordErrorsTo(&error);
  if (!parser.ParseFromString(text, &message)) throw ConfigError(name + ":" + error.text);
}

fs::path PresetsFolder() {
  const fs::path module = ThisModule();
  // bin/sprout-refine and lib/x86_64-linux-gnu/libsprout_pipeline.so: at most two levels.
  for (fs::path folder = module; folder.has_relative_path(); folder = folder.parent_path()) {
    std::error_code ignored;
    const fs::path presets = folder.parent_path() / "share/sprout/presets";
    if (fs::is_directory(presets, ignored)) return presets;
  }
  return module.parent_path() / "../share/sprout/presets";
}

void RequireInRange(const Message& config, const std::string& prefix) {
  const Reflection& reflection = *config.GetReflection();
  for (int i = 0; i < config.GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor& field = *config.GetDescriptor()->field(i);
    if (field.is_repeated()) continue;  // a list has no range
    const std::string key = prefix.empty() ? field.name() : prefix + "." + field.name();
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      RequireInRange(reflection.GetMessage(config, &field), key);
      continue;
    }
    if (!field.options().HasExtension(range)) continue;
    const Range& allowed = field.options().GetExtension(range);
    const double value = NumberIn(config, field);
    if (value >= allowed.min() && value <= allowed.max()) continue;  // false for NaN
    std::ostringstream text;
    text.precision(15);  // 1000001 is not to read as 1e+06
    text << key << " = " << value << ": out of range; allowed: " << allowed.min() << " to "
         << allowed.max();
    throw ConfigError(text.str());
  }
}

SproutConfig LoadConfig(const std::vector<std::string>& files) {
  SproutConfig config;
  for (const std::string& file : files) MergeFile(file, config);
  MakeDefaultsExplicit(config);
  RequireInRange(config, "");
  return config;
}

std::string ConfigText(const Message& config) {
  std::string text;
  TextFormat::PrintToString(config, &text);
  return text;
}

}  // namespace sprout
