#include <google/protobuf/message.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>

#include "common/core/digest.h"
#include "common/core/printable.h"
#include "services/python/arrays.h"
#include "services/python/bindings.h"

namespace sprout::python {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

py::dict DictOf(const Message& message);

py::list ListOf(const Message& message, const FieldDescriptor& field) {
  const auto& reflection = *message.GetReflection();
  const auto append_all = [&](auto get) {
    py::list list;
    for (int i = 0; i < reflection.FieldSize(message, &field); ++i) list.append(get(i));
    return list;
  };
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_STRING:
      return append_all([&](int i) { return reflection.GetRepeatedString(message, &field, i); });
    case FieldDescriptor::CPPTYPE_INT32:
      return append_all([&](int i) { return reflection.GetRepeatedInt32(message, &field, i); });
    default:
      throw std::logic_error("list of an unsupported type: " + field.full_name());
  }
}

py::object ValueOf(const Message& message, const FieldDescriptor& field) {
  if (field.is_repeated()) return ListOf(message, field);
  const auto& reflection = *message.GetReflection();
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return DictOf(reflection.GetMessage(message, &field));
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return py::float_(reflection.GetDouble(message, &field));
    case FieldDescriptor::CPPTYPE_INT32:
      return py::int_(reflection.GetInt32(message, &field));
    case FieldDescriptor::CPPTYPE_UINT32:
      return py::int_(reflection.GetUInt32(message, &field));
    case FieldDescriptor::CPPTYPE_BOOL:
      return py::bool_(reflection.GetBool(message, &field));
    case FieldDescriptor::CPPTYPE_ENUM:
      return py::str(reflection.GetEnum(message, &field)->name());
    default:
      return TextOfBytes(reflection.GetString(message, &field));
  }
}

py::dict DictOf(const Message& message) {
  py::dict dict;
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor& field = *message.GetDescriptor()->field(i);
    dict[py::str(field.name())] = ValueOf(message, field);
  }
  return dict;
}

py::object Get(const SproutConfig& config, const std::string& key) {
  const Message* message = &config;
  for (size_t begin = 0;;) {
    const size_t dot = key.find('.', begin);
    const FieldDescriptor* field =
        message->GetDescriptor()->FindFieldByName(key.substr(begin, dot - begin));
    const bool is_part = field && field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
    if (!field || (dot != std::string::npos && !is_part)) {
      throw py::key_error(Printable(key) +
                          ": no such key; allowed: as in sprout.proto, \"grow.sub_pixel\"");
    }
    if (dot == std::string::npos) return ValueOf(*message, *field);
    message = &message->GetReflection()->GetMessage(*message, field);
    begin = dot + 1;
  }
}

// Removes the keys whose values are the defaults.
void KeepDifferences(Message& message) {
  const auto& reflection = *message.GetReflection();
  const Message& defaults = *reflection.GetMessageFactory()->GetPrototype(message.GetDescriptor());
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor* field = message.GetDescriptor()->field(i);
    bool same = false;
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      Message& part = *reflection.MutableMessage(&message, field);
      KeepDifferences(part);
      same = part.ByteSizeLong() == 0;
    } else {
      same = ValueOf(message, *field).equal(ValueOf(defaults, *field));
    }
    if (same) reflection.ClearField(&message, field);
  }
}

// A Python expression that makes the same configuration.
std::string Repr(SproutConfig config) {
  KeepDifferences(config);
  const std::string text = config.ShortDebugString();
  return "Config(" + (text.empty() ? "" : std::string(py::repr(py::str(text)))) + ")";
}

std::string TextOf(const py::handle& part) {
  if (py::isinstance<py::str>(part)) return BytesOfText(py::reinterpret_borrow<py::str>(part));
  // A path object is always a file, also one without a folder: only a str may name a preset.
  if (py::hasattr(part, "__fspath__")) {
    const auto path = part.cast<std::filesystem::path>().string();
    return path.find('/') == std::string::npos ? "./" + path : path;
  }
  if (py::isinstance<SproutConfig>(part)) return ConfigText(part.cast<const SproutConfig&>());
  throw py::value_error(
      "config: expected a preset, a path or text (str, os.PathLike, Config), given " +
      ReprInOneLine(part));
}

SproutConfig FromParts(const py::args& parts) {
  std::vector<std::string> files;
  for (const py::handle part : parts) {
    if (py::isinstance<py::list>(part) || py::isinstance<py::tuple>(part)) {
      for (const py::handle inner : part) files.push_back(TextOf(inner));
    } else {
      files.push_back(TextOf(part));
    }
  }
  return LoadConfig(files);
}

}  // namespace

SproutConfig TakeConfig(const py::handle& config) {
  if (py::isinstance<SproutConfig>(config)) return config.cast<SproutConfig>();
  return FromParts(py::make_tuple(config));
}

void BindConfig(py::module_& module) {
  py::class_<SproutConfig>(module, "Config",
                           R"(A configuration: every parameter of every stage.

    Config("default")                                   a preset: default, fast, paper
    Config("my.textproto")                              a file, protobuf text format
    Config("fast", "grow { sub_pixel: true }")          several, later ones over earlier ones

Keys, units, defaults and ranges are those of sprout.proto. Cannot be changed; can be pickled.)")
      .def(py::init(&FromParts),
           R"(__init__(self, *parts: Union[str, os.PathLike[str], Config]) -> None

Presets, files, texts (with a '{' in them) and other configurations, merged; none: all defaults.
ValueError names the first key that is unknown, or out of range, and what is allowed.)")
      .def_property_readonly(
          "text", [](const SproutConfig& config) { return ConfigText(config); },
          "str: all of it, in protobuf text format.")
      .def_property_readonly(
          "digest", [](const SproutConfig& config) { return Digest(ConfigText(config)); },
          "str: 16 hexadecimal digits, equal for equal configurations; in every status.")
      .def(
          "to_dict", [](const SproutConfig& config) { return DictOf(config); },
          R"(to_dict(self) -> Dict[str, Any]

All of it as dicts in a dict; enumerations by their names.)")
      .def("__getitem__", &Get, py::arg("key"),
           R"(__getitem__(self, key: str) -> Any

The value of a key, config["grow.sub_pixel"], or a part as a dict, config["grow"].)")
      .def(
          "__eq__",
          [](const SproutConfig& config, const py::object& other) {
            return py::isinstance<SproutConfig>(other) &&
                   ConfigText(config) == ConfigText(other.cast<const SproutConfig&>());
          },
          "__eq__(self, other: object) -> bool")
      .def(
          "__hash__",
          [](const SproutConfig& config) { return py::hash(py::str(ConfigText(config))); },
          "__hash__(self) -> int")
      .def(
          "__repr__", [](const SproutConfig& config) { return Repr(config); },
          "__repr__(self) -> str")
      .def("__reduce__", [](const SproutConfig& config) {
        return py::make_tuple(py::type::of<SproutConfig>(), py::make_tuple(ConfigText(config)));
      });
}

}  // namespace sprout::python
