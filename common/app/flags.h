#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace CLI {
class App;  // only flags.cc includes <CLI/CLI.hpp>, which takes seconds to compile
class Option;
}  // namespace CLI

namespace sprout {

/// A flag ("--name") or an argument ("NAME") of a program. A handle, valid as long as its Flags.
class Flag {
 public:
  explicit Flag(CLI::Option* option) : option_(option) {}

  Flag& Required();

  /// --help shows the value that the variable has now, or a text in its place.
  Flag& ShowDefault();
  Flag& ShowDefault(const std::string& text);

  /// The values that are allowed: numbers from low to high, whole ones, one of these texts.
  Flag& Within(double low, double high);
  Flag& WithinWhole(int64_t low, int64_t high);
  Flag& OneOf(const std::vector<std::string>& texts);

  /// The value is the path of something that exists, or of a file that exists.
  Flag& ExistingPath();
  Flag& ExistingFile();

  /// For a flag with a list: each occurrence of the flag has one value, and all are kept.
  Flag& Repeatable();

  /// For a flag with a list: a value is split at its commas; nothing between two is refused.
  Flag& SplitAtCommas();

  /// Can be given only with the other flag, or only without it.
  Flag& Needs(const Flag& other);
  Flag& Excludes(const Flag& other);

  /// If the flag is not given, its value is taken from this environment variable, if that is set.
  Flag& Environment(const std::string& variable);

 private:
  friend class Flags;
  CLI::Option* option_;
};

/// The flags, arguments and commands of a program. It is declared what sets which variable, with
/// the text for --help; Parse() sets the variables. Variables must outlive it.
class Flags {
 public:
  /// @param description  what --help says first.
  Flags(const std::string& program, const std::string& description);
  ~Flags();

  std::string program() const;

  /// A flag or an argument with a value; of a bool, a flag without one, which sets it to true. If
  /// it is not given the variable stays as it is.
  /// @param name    "--out FILE", "OUT": for the value --help shows FILE, else its type ("INT").
  /// @tparam Value  a text, path or number, an optional or a list of them: those of flags.cc.
  template <typename Value>
  Flag Add(const std::string& name, Value& value, const std::string& help);

  /// A flag like --version: does something in place of the program's work.
  void AddAction(const std::string& name, std::function<void()> act, const std::string& help);

  /// Adds --version, which prints the program's name and the text, unless there is one already.
  void AddVersion(const std::string& version);

  /// @pre there is a flag of that name.
  Flag Get(const std::string& name) const;

  /// Text below the list of flags.
  void SetFooter(const std::string& text);

  /// Adds a command: "sprout-log info". Valid as long as this object.
  /// @param run  its work, for RunCommand(); returns an exit code.
  Flags& AddCommand(const std::string& name, const std::string& description,
                    std::function<int()> run = {});

  /// For a command: it also takes the program's flags that are declared so far, except these. Its
  /// --help lists them.
  void InheritExcept(const std::vector<std::string>& names);

  /// One of the commands has to be given.
  void RequireCommand();

  /// For a command: whether the command line has it.
  bool IsGiven() const;

  /// Whether a command was given, and its work.
  bool HasCommand() const;
  int RunCommand() const;

  /// Sets the variables. An empty value is refused, except for --channel-prefix and for a COMMAND.
  /// @returns false for --help, --version and the like, which it has done.
  /// @throws ConfigError that names the flag, the value and what is allowed.
  bool Parse(int argc, const char* const* argv);

 private:
  explicit Flags(CLI::App* command, Flags* program);

  std::unique_ptr<CLI::App> owned_;  // of a program
  CLI::App* app_;
  Flags* program_ = nullptr;  // of a command
  std::function<int()> run_;  // of a command
  std::string inherited_;     // the same: what --help says of the program's flags
  std::vector<std::unique_ptr<Flags>> commands_;
};

}  // namespace sprout
