#include "tests/rig/fake_camera_features.h"

#include <arv.h>
#include <fmt/core.h>

#include <utility>
#include <vector>

namespace sprout {
namespace {

using Entries = std::vector<std::pair<std::string, uint32_t>>;

std::string Node(const std::string& kind, const std::string& name, const std::string& inside) {
  return fmt::format("<{0} Name=\"{1}\">{2}</{0}>\n", kind, name, inside);
}

// @param access  RO, RW or WO.
std::string RegisterAt(const std::string& kind, const std::string& name, uint32_t address,
                       int bytes, const std::string& access, const std::string& more = "") {
  return Node(kind, name,
              fmt::format("<Address>{:#x}</Address>{}<Length>{}</Length><AccessMode>{}</AccessMode>"
                          "<pPort>Device</pPort>{}",
                          address, more, bytes, access,
                          kind == "StringReg" ? "" : "<Endianess>BigEndian</Endianess>"));
}

std::string Text(const std::string& name, uint32_t address, int bytes) {
  return RegisterAt("StringReg", name, address, bytes, "RO");
}

std::string Int(const std::string& name, uint32_t address, const std::string& access = "RW") {
  return RegisterAt("IntReg", name, address, 4, access);
}

std::string Double(const std::string& name, uint32_t address) {
  return RegisterAt("FloatReg", name, address, 8, "RO");
}

// A whole number in a register as one that has bounds, or as `to` computes it.
std::string Float(const std::string& name, uint32_t address, const std::string& bounds,
                  const std::string& to = "FROM", const std::string& from = "TO") {
  return Int(name + "Reg", address) +
         Node("Converter", name + "Converter",
              fmt::format("<FormulaTo>{}</FormulaTo><FormulaFrom>{}</FormulaFrom>"
                          "<pValue>{}Reg</pValue>",
                          to, from, name)) +
         Node("Float", name, fmt::format("<pValue>{}Converter</pValue>{}", name, bounds));
}

std::string Constant(const std::string& kind, const std::string& name, int value) {
  return Node(kind, name, fmt::format("<Value>{}</Value>", value));
}

std::string Enumeration(const std::string& name, const Entries& entries, const std::string& value) {
  std::string inside;
  for (const auto& [entry, number] : entries) {
    inside += Node("EnumEntry", entry, fmt::format("<Value>{}</Value>", number));
  }
  return Node("Enumeration", name, inside + value);
}

std::string Enumeration(const std::string& name, const Entries& entries, uint32_t address,
                        const std::string& more = "") {
  return RegisterAt("IntReg", name + "Reg", address, 4, "RW", more) +
         Enumeration(name, entries, fmt::format("<pValue>{}Reg</pValue>", name));
}

std::string Command(const std::string& name, uint32_t address, int value) {
  return Int(name + "Reg", address, "WO") +
         Node("Command", name,
              fmt::format("<pValue>{}Reg</pValue><CommandValue>{}</CommandValue>", name, value));
}

std::string Trigger() {
  const std::string of_selector = "<pIndex Offset=\"0x20\">TriggerSelectorValue</pIndex>";
  return Constant("Integer", "TriggerSelectorValue", 0) +
         Enumeration("TriggerSelector", {{"FrameStart", 0}, {"AcquisitionStart", 1}},
                     "<pValue>TriggerSelectorValue</pValue>") +
         Enumeration("TriggerMode", {{"Off", 0}, {"On", 1}}, ARV_FAKE_CAMERA_REGISTER_TRIGGER_MODE,
                     of_selector) +
         Enumeration("TriggerSource", {{"Line0", 0}, {"Software", 1}},
                     ARV_FAKE_CAMERA_REGISTER_TRIGGER_SOURCE, of_selector) +
         Enumeration("TriggerActivation", {{"RisingEdge", 0}},
                     ARV_FAKE_CAMERA_REGISTER_TRIGGER_ACTIVATION, of_selector) +
         Command("TriggerSoftware", ARV_FAKE_CAMERA_REGISTER_TRIGGER_SOFTWARE, 1);
}

// The features of a ToF camera (SFNC, 3D Scan Control).
std::string Scan3d() {
  return Constant("Integer", "Scan3dCoordinateSelectorValue", 2) +
         Enumeration("Scan3dCoordinateSelector",
                     {{"CoordinateA", 0}, {"CoordinateB", 1}, {"CoordinateC", 2}},
                     "<pValue>Scan3dCoordinateSelectorValue</pValue>") +
         Double("Scan3dCoordinateScale", kScale) + Constant("Float", "Scan3dCoordinateOffset", 0) +
         Node("Boolean", "Scan3dInvalidDataFlag",
              "<Value>1</Value><OnValue>1</OnValue><OffValue>0</OffValue>") +
         Constant("Float", "Scan3dInvalidDataValue", 65535) +
         Enumeration("Scan3dDistanceUnit", {{"Millimeter", 0}, {"Inch", 1}}, "<Value>0</Value>") +
         Enumeration("Scan3dCoordinateSystem",
                     {{"Cartesian", 0}, {"Spherical", 1}, {"Cylindrical", 2}}, kCoordinateSystem) +
         Double("Scan3dFocalLength", kFocalLength) + Double("Scan3dPrincipalPointU", kPrincipalU) +
         Double("Scan3dPrincipalPointV", kPrincipalV);
}

}  // namespace

std::string FakeCameraFeatures() {
  // Numbers as PFNC and vendors give them, not as Sprout does; Mono12 it does not read.
  const Entries formats = {{"Mono8", 0x01080001},       {"BayerGR8", 0x01080008},
                           {"BayerRG8", 0x01080009},    {"BayerGB8", 0x0108000a},
                           {"BayerBG8", 0x0108000b},    {"RGB8", 0x02180014},
                           {"Mono12", 0x01100005},      {"Mono16", 0x01100007},
                           {"Coord3D_C16", 0x011000b8}, {"Coord3D_ABCY16", 0x82400403}};
  return "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n"
         "<RegisterDescription ModelName=\"Fake\" VendorName=\"Sprout\" StandardNameSpace=\"None\" "
         "SchemaMajorVersion=\"1\" SchemaMinorVersion=\"1\" SchemaSubMinorVersion=\"0\" "
         "MajorVersion=\"1\" MinorVersion=\"0\" SubMinorVersion=\"0\" ToolTip=\"Camera of the fake "
         "rig\" ProductGuid=\"0\" VersionGuid=\"0\" "
         "xmlns=\"http://www.genicam.org/GenApi/Version_1_1\">\n" +
         // GigE Vision's own registers.
         Text("DeviceVendorName", 0x48, 32) + Text("DeviceModelName", 0x68, 32) +
         Text("DeviceSerialNumber", 0xd8, 16) +
         Int("SensorWidth", ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, "RO") +
         Int("SensorHeight", ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT, "RO") +
         Int("Width", ARV_FAKE_CAMERA_REGISTER_WIDTH) +
         Int("Height", ARV_FAKE_CAMERA_REGISTER_HEIGHT) +
         Enumeration("PixelFormat", formats, ARV_FAKE_CAMERA_REGISTER_PIXEL_FORMAT) +
         Node("IntSwissKnife", "PayloadSize",
              "<pVariable Name=\"W\">Width</pVariable><pVariable Name=\"H\">Height</pVariable>"
              "<pVariable Name=\"F\">PixelFormat</pVariable>"
              "<Formula>W * H * ((F &gt;&gt; 16) &amp; 0xff) / 8</Formula>") +
         Command("AcquisitionStart", ARV_FAKE_CAMERA_REGISTER_ACQUISITION, 1) +
         Command("AcquisitionStop", ARV_FAKE_CAMERA_REGISTER_ACQUISITION, 0) +
         Enumeration("AcquisitionMode", {{"Continuous", 1}, {"SingleFrame", 2}, {"MultiFrame", 3}},
                     ARV_FAKE_CAMERA_REGISTER_ACQUISITION_MODE) +
         Float("AcquisitionFrameRate", ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US,
               "<Min>0.1</Min><Max>1000.0</Max>", "(1000000 / FROM)", "(1000000 / TO)") +
         Float("ExposureTime", ARV_FAKE_CAMERA_REGISTER_EXPOSURE_TIME_US,
               "<Min>10.0</Min><Max>1000000.0</Max>") +
         Float("Gain", ARV_FAKE_CAMERA_REGISTER_GAIN_RAW, "<Min>0.0</Min><Max>24.0</Max>") +
         Trigger() + Scan3d() + Command("TimestampLatch", kTimestampLatch, 1) +
         RegisterAt("IntReg", "TimestampLatchValue", kTimestampLatchValue, 8, "RO",
                    "<Cachable>NoCache</Cachable>") +
         "<Port Name=\"Device\"/>\n</RegisterDescription>\n";
}

}  // namespace sprout
