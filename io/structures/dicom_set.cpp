#include "io/structures/dicom_set.h"

#include "slicemorph/errors.h"

#include <gdcmDicts.h>
#include <gdcmGlobal.h>
#include <gdcmSequenceOfItems.h>
#include <gdcmSmartPointer.h>
#include <gdcmTrace.h>
#include <gdcmWriter.h>
#include <itksys/MD5.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <sstream>

namespace slicemorph {
namespace {

gdcm::Tag tagOf(DicomTag tag) { return {std::uint16_t(tag >> 16), std::uint16_t(tag & 0xffff)}; }

gdcm::VR representationOf(DicomTag tag) {
  static const gdcm::Dicts& dicts = gdcm::Global::GetInstance().GetDicts();
  const gdcm::VR known = dicts.GetDictEntry(tagOf(tag)).GetVR();
  return known == gdcm::VR::OB_OW ? gdcm::VR(gdcm::VR::OB) : known;
}

template <typename Number>
std::string bytesOfNumbers(const std::vector<Number>& values) {
  static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "numbers are written as they lie in memory");
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number)};
}

using Digest = std::array<unsigned char, 16>;

Digest md5(const std::string& text) {
  Digest digest;
  itksysMD5* state = itksysMD5_New();
  itksysMD5_Initialize(state);
  constexpr size_t kPart = size_t(1) << 30;  // lengths are ints
  for (size_t at = 0; at < text.size(); at += kPart)
    itksysMD5_Append(state, reinterpret_cast<const unsigned char*>(text.data()) + at,
                     int(std::min(kPart, text.size() - at)));
  itksysMD5_Finalize(state, digest.data());
  itksysMD5_Delete(state);
  return digest;
}

/// A number of 128 bits, the first byte the highest, in decimal.
std::string decimalOf(Digest number) {
  std::string digits;
  while (std::any_of(number.begin(), number.end(), [](unsigned char c) { return c != 0; })) {
    unsigned rest = 0;
    for (unsigned char& byte : number) {
      rest = rest << 8 | byte;
      byte = static_cast<unsigned char>(rest / 10), rest %= 10;
    }
    digits.insert(digits.begin(), char('0' + rest));
  }
  return digits.empty() ? "0" : digits;
}

}  // namespace

std::string decimalString(double value) {
  char text[40];
  for (int digits = 16; digits > 0; --digits) {
    std::snprintf(text, sizeof text, "%.*g", digits, value + 0.0);
    if (std::strlen(text) <= 16) break;
  }
  return text;
}

void DicomSet::add(DicomTag tag, std::string value, char padding) {
  if (value.size() % 2) value += padding;
  gdcm::DataElement element(tagOf(tag));
  element.SetVR(representationOf(tag));
  element.SetByteValue(value.data(), gdcm::VL(std::uint32_t(value.size())));
  set_.Replace(element);
}

DicomSet& DicomSet::text(DicomTag tag, const std::string& value) {
  add(tag, value, representationOf(tag) == gdcm::VR::UI ? '\0' : ' ');
  return *this;
}

DicomSet& DicomSet::decimals(DicomTag tag, const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : "\\") + decimalString(value);
  return this->text(tag, text);
}

DicomSet& DicomSet::shorts(DicomTag tag, const std::vector<std::uint16_t>& values) {
  add(tag, bytesOfNumbers(values), '\0');
  return *this;
}

DicomSet& DicomSet::longs(DicomTag tag, const std::vector<std::uint32_t>& values) {
  add(tag, bytesOfNumbers(values), '\0');
  return *this;
}

DicomSet& DicomSet::pointer(DicomTag tag, DicomTag to) {
  return shorts(tag, {std::uint16_t(to >> 16), std::uint16_t(to & 0xffff)});
}

DicomSet& DicomSet::bytes(DicomTag tag, const std::string& value) {
  add(tag, value, '\0');
  return *this;
}

DicomSet& DicomSet::items(DicomTag tag, const std::vector<DicomSet>& sets) {
  gdcm::SmartPointer<gdcm::SequenceOfItems> sequence = new gdcm::SequenceOfItems;
  sequence->SetLengthToUndefined();
  for (const DicomSet& set : sets) {
    gdcm::Item item;
    item.SetVLToUndefined();
    item.SetNestedDataSet(set.set_);
    sequence->AddItem(item);
  }
  gdcm::DataElement element(tagOf(tag));
  element.SetVR(gdcm::VR::SQ);
  element.SetValue(*sequence);
  element.SetVLToUndefined();
  set_.Replace(element);
  return *this;
}

DicomSet& DicomSet::code(DicomTag tag, const char* value, const char* scheme, const char* meaning) {
  return item(tag, DicomSet().text(0x00080100, value).text(0x00080102, scheme).text(0x00080104, meaning));
}

std::string DicomSet::file(bool implicit) const {
  gdcm::Trace::WarningOff(), gdcm::Trace::ErrorOff(), gdcm::Trace::DebugOff();
  gdcm::Writer writer;
  gdcm::File& file = writer.GetFile();
  file.SetDataSet(set_);
  file.GetHeader().SetDataSetTransferSyntax(implicit ? gdcm::TransferSyntax::ImplicitVRLittleEndian
                                                     : gdcm::TransferSyntax::ExplicitVRLittleEndian);
  std::ostringstream bytes;
  writer.SetStream(bytes);
  if (!writer.Write() || !bytes) throw IoError("", "the DICOM file could not be put together");
  return bytes.str();
}

ContentUids::ContentUids(const std::string& content) {
  const Digest digest = md5(content);
  digest_.assign(digest.begin(), digest.end());
}

std::string ContentUids::of(const std::string& thing) const {
  Digest uuid = md5(digest_ + thing);
  uuid[6] = static_cast<unsigned char>((uuid[6] & 0x0f) | 0x30);
  uuid[8] = static_cast<unsigned char>((uuid[8] & 0x3f) | 0x80);
  return "2.25." + decimalOf(uuid);
}

}  // namespace slicemorph
