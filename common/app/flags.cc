#include "common/app/flags.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cassert>
#include <filesystem>
#include <limits>
#include <optional>
#include <set>
#include <span>
#include <sstream>
#include <string_view>
#include <type_traits>
#include <utility>

#include "common/app/help_text.h"
#include "common/config/config_error.h"
#include "common/core/input_files.h"
#include "common/core/joined.h"
#include "common/core/number_text.h"
#include "common/core/read_text.h"

namespace sprout {
namespace {

std::string ListOf(const std::string& label, const std::set<CLI::Option*>& options) {
  std::set<std::string> names;
  for (const CLI::Option* option : options) names.insert(option->get_name());
  std::string text = names.empty() ? "" : " " + label;
  for (const std::string& name : names) text += " " + name;
  return text;
}

// CLI11 has a line for each flag, however much there is to say, and lists other flags in the order
// of their addresses.
class Formatter : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override {
    return WrapLines(CLI::Formatter::make_help(app, std::move(name), mode), get_column_width());
  }

  std::string make_option_opts(const CLI::Option* option) const override {
    const std::string text = CLI::Formatter::make_option_opts(option);
    return text.substr(0, std::min(text.find(" Needs:"), text.find(" Excludes:"))) +
           ListOf("Needs:", option->get_needs()) + ListOf("Excludes:", option->get_excludes());
  }
};

// CLI::Range would accept NaN.
CLI::Validator NumberIn(double low, double high) {
  std::ostringstream allowed;
  allowed << "a number from " << low << " to " << high;
  return {[=, text_of_allowed = allowed.str()](const std::string& text) -> std::string {
            const std::optional<double> value = ParseNumber<double>(text);
            if (value && *value >= low && *value <= high) return {};
            return "'" + text + "' is not allowed: " + text_of_allowed;
          },
          allowed.str()};
}

// CLI11 takes 99999999999999999999 for the largest number there is, -1 for a large one where there
// are no negative ones, and 010 for 8.
template <typename Number>
CLI::Validator Whole() {
  return {[](std::string& text) -> std::string {
            const std::optional<Number> number = ParseNumber<Number>(text);
            if (number) text = std::to_string(*number);
            return number ? ""
                          : "'" + text + "' is not allowed: a whole number up to " +
                                std::to_string(std::numeric_limits<Number>::max());
          },
          ""};
}

template <typename Value>
Value ElementOf(const Value&);
template <typename Value>
Value ElementOf(const std::optional<Value>&);
template <typename Value>
Value ElementOf(const std::vector<Value>&);

// Notes a file that has to exist: it is read, so nothing that the program writes may replace it.
CLI::Validator Noted() {
  return {[](const std::string& path) -> std::string {
            NoteInputFile(path);
            return {};
          },
          ""};
}

CLI::Validator Open() {
  return {[](const std::string& path) {
            const std::string why = WhyClosed(path);
            return why.empty() ? "" : path + ": cannot be read" + why;
          },
          ""};
}

// An empty prefix is valid, and a COMMAND is run by another program.
constexpr std::array<std::string_view, 2> kMayBeEmpty = {"--channel-prefix", "COMMAND"};

// An empty text means what no flag means, and that is not what `--log "$FILE"` asks for when FILE
// is not set. `--dir=~/logs` would make a folder named ~ here.
void RequireMeantTexts(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    const std::string name = option->get_name();
    if (std::find(kMayBeEmpty.begin(), kMayBeEmpty.end(), name) != kMayBeEmpty.end()) continue;
    for (const std::string& text : option->results()) {
      if (text.empty()) throw ConfigError(name + " '': allowed is a text that is not empty");
      if (text != "~" && !text.starts_with("~/")) continue;
      throw ConfigError(name + " '" + text +
                        "': shells replace ~ only in front of a word and without quotes");
    }
  }
  for (const CLI::App* command : app.get_subcommands()) RequireMeantTexts(*command);
}

// For a list of commas alone CLI11 takes the next argument, and blanks for letters of names.
void RequireNames(const CLI::App& app, std::span<const char* const> arguments) {
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_delimiter() != ',') continue;
    const std::string name = option->get_name();
    for (size_t i = 0; i < arguments.size(); ++i) {
      std::string_view list = arguments[i];
      if (list == name && i + 1 < arguments.size()) {
        list = arguments[i + 1];
      } else if (list.starts_with(name + "=")) {
        list.remove_prefix(name.size() + 1);
      } else {
        continue;
      }
      const auto is_name = [](auto text) { return !text.empty() && text == Trimmed(text); };
      if (list.empty() || std::ranges::all_of(SplitAt(',', list), is_name)) continue;
      throw ConfigError(name + " '" + std::string(list) +
                        "': allowed are names with one comma between them, without blanks");
    }
  }
  for (const CLI::App* command : app.get_subcommands({})) {
    if (std::ranges::count(arguments, std::string_view(command->get_name())) == 0) continue;
    RequireNames(*command, arguments);
  }
}

bool IsFlag(const std::string& argument) { return argument.size() > 1 && argument[0] == '-'; }

// The names that may stand at a place of the command line: the flags, or the commands, of the
// program and of the command that was given.
std::vector<std::string> NamesLike(const std::string& argument, const CLI::App& app) {
  std::vector<std::string> names;
  if (!IsFlag(argument)) {
    for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
    return names;
  }
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  for (const CLI::App* command : app.get_subcommands()) {
    const std::vector<std::string> more = NamesLike(argument, *command);
    names.insert(names.end(), more.begin(), more.end());
  }
  return names;
}

// What is wrong with the first argument that nothing takes. CLI11 lists all of them, the last one
// first.
std::string UnexpectedText(const std::string& argument, const CLI::App& app) {
  const std::vector<std::string> names = NamesLike(argument, app);
  const std::string word = argument.substr(0, argument.find('='));
  const bool is_flag = IsFlag(argument);
  if (!is_flag && (names.empty() || !app.get_subcommands().empty())) {
    return "'" + argument + "' is one argument too many (--help lists what is taken)";
  }
  const std::string nearest = NearestName(word, names);
  const std::string begin = (is_flag ? word : "'" + word + "'") + " is no " +
                            (is_flag ? "flag" : "command") + " of " + app.get_name();
  return begin + (nearest.empty() ? "" : ": did you mean " + nearest + "?") +
         " (--help lists the " + (is_flag ? "flags)" : "commands)");
}

// What CLI11 says of a flag that has no value, too many of them, or no number: without what is
// allowed, and as if every value came from the command line.
std::string ErrorText(const CLI::ParseError& error) {
  const std::string what = error.what();
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ArgumentMismatch)) {
    const bool is_twice = what.find("At Most") != std::string::npos;
    return what.substr(0, what.find(':')) +
           (is_twice ? " is given more than once" : " needs a value");
  }
  constexpr std::string_view kNoNumber = "Could not convert: ";
  if (what.starts_with(kNoNumber)) return what.substr(kNoNumber.size()) + ": allowed is a number";
  return what;
}

// The first argument that no flag or command takes; empty if all are taken.
std::string FirstUnexpected(const CLI::App& app) {
  for (const std::string& argument : app.remaining()) return argument;
  for (const CLI::App* command : app.get_subcommands()) {
    if (std::string argument = FirstUnexpected(*command); !argument.empty()) return argument;
  }
  return "";
}

bool MayBeUnexpected(const CLI::ParseError& error) {
  const int code = error.get_exit_code();
  return code == static_cast<int>(CLI::ExitCodes::ExtrasError) ||
         code == static_cast<int>(CLI::ExitCodes::RequiredError) ||
         code == static_cast<int>(CLI::ExitCodes::RequiresError);
}

}  // namespace

Flag& Flag::Required() {
  option_->required();
  return *this;
}

Flag& Flag::ShowDefault() {
  option_->capture_default_str();
  return *this;
}

Flag& Flag::ShowDefault(const std::string& text) {
  option_->default_str(text);
  return *this;
}

Flag& Flag::Within(double low, double high) {
  option_->check(NumberIn(low, high));
  return *this;
}

Flag& Flag::WithinWhole(int64_t low, int64_t high) {
  option_->check(CLI::Range(low, high));
  return *this;
}

Flag& Flag::OneOf(const std::vector<std::string>& texts) {
  option_->check(CLI::IsMember(texts));
  return *this;
}

Flag& Flag::ExistingPath() {
  option_->check(Open())->check(CLI::ExistingPath)->check(Noted());
  return *this;
}

Flag& Flag::ExistingFile() {
  option_->check(Open())->check(CLI::ExistingFile)->check(Noted());
  return *this;
}

Flag& Flag::Repeatable() {
  option_->expected(1)->take_all();
  return *this;
}

Flag& Flag::SplitAtCommas() {
  option_->delimiter(',');
  return *this;
}

Flag& Flag::Needs(const Flag& other) {
  option_->needs(other.option_);
  return *this;
}

Flag& Flag::Excludes(const Flag& other) {
  option_->excludes(other.option_);
  return *this;
}

Flag& Flag::Environment(const std::string& variable) {
  option_->envname(variable);
  return *this;
}

Flags::Flags(const std::string& program, const std::string& description)
    : owned_(std::make_unique<CLI::App>(description, program)), app_(owned_.get()) {
  app_->formatter(std::make_shared<Formatter>());  // commands take it over
}

Flags::Flags(CLI::App* command, Flags* program) : app_(command), program_(program) {}

Flags::~Flags() = default;

std::string Flags::program() const { return app_->get_name(); }

template <typename Value>
Flag Flags::Add(const std::string& name, Value& value, const std::string& help) {
  if constexpr (std::is_same_v<Value, bool>) {
    return Flag(app_->add_flag(name, value, help));
  } else {
    const size_t space = name.find(' ');
    CLI::Option* const option = app_->add_option(name.substr(0, space), value, help);
    if (space != std::string::npos) option->type_name(name.substr(space + 1));
    using Element = decltype(ElementOf(value));
    if constexpr (std::is_integral_v<Element>) option->transform(Whole<Element>());
    return Flag(option);
  }
}

template Flag Flags::Add(const std::string&, bool&, const std::string&);
template Flag Flags::Add(const std::string&, int&, const std::string&);
template Flag Flags::Add(const std::string&, int64_t&, const std::string&);
template Flag Flags::Add(const std::string&, uint64_t&, const std::string&);
template Flag Flags::Add(const std::string&, double&, const std::string&);
template Flag Flags::Add(const std::string&, std::string&, const std::string&);
template Flag Flags::Add(const std::string&, std::filesystem::path&, const std::string&);
template Flag Flags::Add(const std::string&, std::optional<int>&, const std::string&);
template Flag Flags::Add(const std::string&, std::optional<int64_t>&, const std::string&);
template Flag Flags::Add(const std::string&, std::optional<double>&, const std::string&);
template Flag Flags::Add(const std::string&, std::optional<std::string>&, const std::string&);
template Flag Flags::Add(const std::string&, std::vector<uint64_t>&, const std::string&);
template Flag Flags::Add(const std::string&, std::vector<std::string>&, const std::string&);
template Flag Flags::Add(const std::string&, std::vector<std::filesystem::path>&,
                         const std::string&);

void Flags::AddAction(const std::string& name, std::function<void()> act, const std::string& help) {
  const auto act_and_end = [act = std::move(act)] {
    act();
    throw CLI::Success();
  };
  app_->add_flag_callback(name, act_and_end, help);
}

void Flags::AddVersion(const std::string& version) {
  if (app_->get_version_ptr() != nullptr) return;
  app_->set_version_flag("--version", program() + " " + version);
}

Flag Flags::Get(const std::string& name) const { return Flag(app_->get_option(name)); }

void Flags::SetFooter(const std::string& text) { app_->footer(inherited_ + text); }

Flags& Flags::AddCommand(const std::string& name, const std::string& description,
                         std::function<int()> run) {
  commands_.push_back(
      std::unique_ptr<Flags>(new Flags(app_->add_subcommand(name, description), this)));
  commands_.back()->run_ = std::move(run);
  return *commands_.back();
}

void Flags::InheritExcept(const std::vector<std::string>& names) {
  app_->fallthrough();
  std::set<const CLI::Option*> excluded;
  for (const std::string& name : names) {
    CLI::Option* const option = program_->app_->get_option(name);
    app_->excludes(option);
    excluded.insert(option);
  }
  const auto* const formatter = dynamic_cast<const CLI::Formatter*>(app_->get_formatter().get());
  assert(formatter != nullptr);
  for (const CLI::Option* option : program_->app_->get_options()) {
    const bool is_of_program = option == program_->app_->get_help_ptr() ||
                               option == program_->app_->get_option_no_throw("--version");
    if (is_of_program || excluded.contains(option)) continue;
    inherited_ += formatter->make_option(option, /*is_positional=*/false);
  }
  inherited_ = "\nOptions of " + program_->program() + ":\n" + inherited_;
  app_->footer(inherited_);
}

void Flags::RequireCommand() { app_->require_subcommand(1); }

bool Flags::IsGiven() const { return app_->parsed(); }

bool Flags::HasCommand() const { return !app_->get_subcommands().empty(); }

int Flags::RunCommand() const {
  for (const std::unique_ptr<Flags>& command : commands_) {
    if (command->IsGiven()) return command->run_();
  }
  assert(false);
  return 1;
}

bool Flags::Parse(int argc, const char* const* argv) {
  RequireNames(*app_, {argv, static_cast<size_t>(argc)});
  try {
    app_->parse(argc, argv);
  } catch (const CLI::Success& e) {  // --help, --version
    app_->exit(e);
    return false;
  } catch (const CLI::ParseError& e) {
    const std::string unexpected = MayBeUnexpected(e) ? FirstUnexpected(*app_) : "";
    if (!unexpected.empty()) throw ConfigError(UnexpectedText(unexpected, *app_));
    if (app_->get_require_subcommand_min() > 0 && app_->get_subcommands().empty()) {
      throw ConfigError("which command? " +
                        Joined(", ", app_->get_subcommands({}), &CLI::App::get_name) +
                        " (--help explains them)");
    }
    throw ConfigError(ErrorText(e) + " (--help lists the flags)");
  }
  RequireMeantTexts(*app_);
  return true;
}

}  // namespace sprout
