#include "io/image/dicom_elements.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace slicemorph {
namespace {

bool isNumeric(std::string_view type) {
  constexpr const char* kTypes[] = {"DS", "IS", "US", "SS", "UL", "SL", "AT", "FL", "FD"};
  return std::find(std::begin(kTypes), std::end(kTypes), type) != std::end(kTypes);
}

double numberAt(std::string_view raw, std::string_view type, bool bigEndian) {
  std::uint64_t bits = 0;
  for (size_t i = 0; i < raw.size(); ++i)
    bits |= std::uint64_t(static_cast<unsigned char>(raw[i])) << (8 * (bigEndian ? raw.size() - 1 - i : i));
  if (type == "FL") {
    const auto low = std::uint32_t(bits);
    float value = 0;
    std::memcpy(&value, &low, sizeof value);
    return double(value);
  }
  if (type == "FD") {
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
  if (type == "SS") return double(std::int16_t(bits));
  if (type == "SL") return double(std::int32_t(bits));
  return double(bits);
}

std::vector<double> decimalsOf(std::string_view text) {
  std::vector<double> numbers;
  while (true) {
    const size_t end = std::min(text.find('\\'), text.size());
    const std::string part(text.substr(0, end));
    char* stop = nullptr;
    const double value = std::strtod(part.c_str(), &stop);
    if (stop == part.c_str() || !std::isfinite(value)) return {};
    numbers.push_back(value);
    if (end == text.size()) return numbers;
    text.remove_prefix(end + 1);
  }
}

}  // namespace

int DicomElements::number(DicomTag tag) const {
  const double value = first(tag, "US", -1);
  return value >= 0 && value <= 65535 ? int(value) : -1;
}

std::string_view DicomElements::bytes(DicomTag tag) const {
  const auto found = values_.find(tag);
  return found == values_.end() ? std::string_view() : found->second.bytes;
}

std::string_view DicomElements::type(DicomTag tag) const {
  const auto found = values_.find(tag);
  return found == values_.end() ? std::string_view() : found->second.type;
}

std::vector<double> DicomElements::numbers(DicomTag tag, std::string_view type) const {
  const auto found = values_.find(tag);
  if (found == values_.end()) return {};
  const std::string_view stated = found->second.type;
  if (isNumeric(stated)) type = stated;
  std::string_view raw = found->second.bytes;
  if (type == "DS" || type == "IS") return decimalsOf(text(tag));
  std::vector<double> out;
  if (type == "AT") {
    for (; raw.size() >= 4; raw.remove_prefix(4))
      out.push_back(numberAt(raw.substr(0, 2), "US", bigEndian_) * 65536 +
                    numberAt(raw.substr(2, 2), "US", bigEndian_));
    return out;
  }
  const size_t size = type == "FD" ? 8 : type == "US" || type == "SS" ? 2 : 4;
  for (; raw.size() >= size; raw.remove_prefix(size))
    out.push_back(numberAt(raw.substr(0, size), type, bigEndian_));
  const bool finite = std::all_of(out.begin(), out.end(), [](double v) { return std::isfinite(v); });
  return finite ? out : std::vector<double>();
}

double DicomElements::first(DicomTag tag, std::string_view type, double otherwise) const {
  const std::vector<double> all = numbers(tag, type);
  return all.empty() ? otherwise : all[0];
}

size_t DicomElements::size(DicomTag tag) const {
  const auto found = values_.find(tag);
  return found == values_.end() ? 0 : found->second.bytes.size();
}

std::string DicomElements::text(DicomTag tag) const {
  const auto found = values_.find(tag);
  if (found == values_.end()) return "";
  std::string text(found->second.bytes);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.pop_back();
  text.erase(0, std::min(text.find_first_not_of(' '), text.size()));
  return text;
}

std::vector<DicomTag> DicomElements::tags() const {
  std::vector<DicomTag> tags;
  for (const auto& [tag, value] : values_) tags.push_back(tag);
  return tags;
}

}  // namespace slicemorph
