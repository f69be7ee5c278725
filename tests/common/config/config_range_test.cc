#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/text_format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>

#include "common/config/config.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/testing/thrown.h"

// Walks every field of the configuration by reflection, so that a new field is tested too.
namespace sprout {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using ::testing::HasSubstr;

struct RangedField {
  std::string key;  ///< "grow.threshold"
  const FieldDescriptor* field;
  Range allowed;
};

using Visit = std::function<void(const std::string& key, Message& parent, const FieldDescriptor&)>;

void VisitFields(Message& message, const std::string& prefix, const Visit& visit) {
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor& field = *message.GetDescriptor()->field(i);
    if (field.is_repeated()) continue;  // a list has neither range nor default
    const std::string key = prefix + field.name();
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      VisitFields(*message.GetReflection()->MutableMessage(&message, &field), key + ".", visit);
    } else {
      visit(key, message, field);
    }
  }
}

std::vector<RangedField> RangedFields() {
  std::vector<RangedField> fields;
  SproutConfig config;
  VisitFields(config, "", [&](const std::string& key, Message&, const FieldDescriptor& field) {
    if (field.options().HasExtension(range)) {
      fields.push_back({key, &field, field.options().GetExtension(range)});
    }
  });
  return fields;
}

SproutConfig DefaultsWith(const RangedField& ranged, double value) {
  SproutConfig config = LoadConfig({});
  VisitFields(config, "", [&](const std::string& key, Message& parent, const FieldDescriptor& f) {
    if (key != ranged.key) return;
    if (f.cpp_type() == FieldDescriptor::CPPTYPE_INT32) {
      parent.GetReflection()->SetInt32(&parent, &f, static_cast<int32_t>(value));
    } else {
      parent.GetReflection()->SetDouble(&parent, &f, value);
    }
  });
  return config;
}

std::string ErrorOf(const SproutConfig& config) {
  return Thrown<ConfigError>([&] { RequireInRange(config, ""); });
}

std::string Text(double number) {
  std::ostringstream text;
  text.precision(15);
  text << number;
  return text.str();
}

bool IsInteger(const RangedField& ranged) {
  return ranged.field->cpp_type() == FieldDescriptor::CPPTYPE_INT32;
}

TEST(ConfigRange, HasBothEndsInOrderAndTheDefaultInside) {
  ASSERT_GE(RangedFields().size(), 10U);
  for (const RangedField& ranged : RangedFields()) {
    EXPECT_TRUE(ranged.allowed.has_min() && ranged.allowed.has_max()) << ranged.key;
    EXPECT_LT(ranged.allowed.min(), ranged.allowed.max()) << ranged.key;
  }
  EXPECT_EQ(ErrorOf(LoadConfig({})), "no error");
}

TEST(ConfigRange, IsStatedForEverySignedNumber) {
  SproutConfig config;
  VisitFields(config, "", [](const std::string& key, Message&, const FieldDescriptor& field) {
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE ||
        field.cpp_type() == FieldDescriptor::CPPTYPE_INT32) {
      EXPECT_TRUE(field.options().HasExtension(range)) << key;
    }
  });
}

TEST(ConfigRange, IncludesBothEnds) {
  for (const RangedField& ranged : RangedFields()) {
    EXPECT_EQ(ErrorOf(DefaultsWith(ranged, ranged.allowed.min())), "no error") << ranged.key;
    EXPECT_EQ(ErrorOf(DefaultsWith(ranged, ranged.allowed.max())), "no error") << ranged.key;
  }
}

TEST(ConfigRange, RefusesWhatIsOutsideAndNamesKeyValueAndRange) {
  const double inf = std::numeric_limits<double>::infinity();
  for (const RangedField& ranged : RangedFields()) {
    const double min = ranged.allowed.min();
    const double max = ranged.allowed.max();
    std::vector<double> outside = {min - 1, max + 1};
    if (!IsInteger(ranged)) {
      for (const double value : {inf, -inf, std::nan("")}) outside.push_back(value);
    }
    for (const double value : outside) {
      EXPECT_EQ(ErrorOf(DefaultsWith(ranged, value)), ranged.key + " = " + Text(value) +
                                                          ": out of range; allowed: " + Text(min) +
                                                          " to " + Text(max));
    }
    if (!IsInteger(ranged)) {
      EXPECT_NE(ErrorOf(DefaultsWith(ranged, std::nextafter(min, -inf))), "no error") << ranged.key;
      EXPECT_NE(ErrorOf(DefaultsWith(ranged, std::nextafter(max, inf))), "no error") << ranged.key;
    }
  }
}

TEST(ConfigRange, IsCheckedWhenAFileIsLoaded) {
  const TemporaryDirectory folder;
  const std::filesystem::path path = folder / "range.textproto";
  for (const RangedField& ranged : RangedFields()) {
    for (const double value : {ranged.allowed.min() - 1, ranged.allowed.max() + 1}) {
      std::ofstream(path) << ConfigText(DefaultsWith(ranged, value));
      EXPECT_THAT(Thrown<ConfigError>([&] { LoadConfig({path.string()}); }), HasSubstr(ranged.key))
          << value;
    }
  }
  std::ofstream(path) << "capture { sr4000 { view_margin: nan } }";
  EXPECT_THROW(LoadConfig({path.string()}), ConfigError);
}

TEST(ConfigRange, OfAPartIsNamedWithThePrefix) {
  CaptureConfig capture;
  capture.mutable_sr4000()->set_view_margin(8);
  EXPECT_EQ(Thrown<ConfigError>([&] { RequireInRange(capture, "capture"); }),
            "capture.sr4000.view_margin = 8: out of range; allowed: 0.5 to 4");
}

TEST(ConfigText, LoadsAgainToTheSameText) {
  const TemporaryDirectory folder;
  const std::filesystem::path path = folder / "text.textproto";
  for (const std::vector<std::string>& files :
       {std::vector<std::string>{}, {"default"}, {"paper"}}) {
    const std::string text = ConfigText(LoadConfig(files));
    std::ofstream(path) << text;
    EXPECT_EQ(ConfigText(LoadConfig({path.string()})), text);
  }
}

TEST(ConfigText, ShowsEveryFieldExplicitly) {
  SproutConfig config;
  ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(ConfigText(LoadConfig({})), &config));
  int fields = 0;
  VisitFields(config, "", [&](const std::string& key, Message& parent, const FieldDescriptor& f) {
    if (f.is_repeated()) return;  // an empty list has no text
    ++fields;
    EXPECT_TRUE(parent.GetReflection()->HasField(parent, &f)) << key;
  });
  EXPECT_GE(fields, 20);
}

}  // namespace
}  // namespace sprout
