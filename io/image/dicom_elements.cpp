#include "io/image/dicom_elements.h"

#include <algorithm>

namespace slicemorph {

namespace {

constexpr std::uint32_t kUndefined = 0xffffffff;
constexpr DicomTag kItem = 0xfffee000, kItemEnd = 0xfffee00d, kSequenceEnd = 0xfffee0dd,
                   kTransferSyntax = 0x00020010, kPixels = 0x7fe00010;
constexpr size_t kPreamble = 128;  // bytes before "DICM", PS3.10 section 7.1
constexpr int kMostNested = 32;    // bounds the recursion over sequences of a damaged or hostile file

bool isAnyOf(std::string_view type, std::initializer_list<const char*> types) {
  for (const char* t : types)
    if (type == t) return true;
  return false;
}

}  // namespace

/// Parses bytes element by element. Everything throws DicomDamage.
class DicomElements::Walk {
 public:
  Walk(std::string_view bytes, bool withTypes, int depth = 0)
      : bytes_(bytes), withTypes_(withTypes), depth_(depth) {
    if (depth > kMostNested) throw DicomDamage("its sequences are nested too deeply");
  }

  bool atEnd() const { return at_ == bytes_.size(); }
  size_t at() const { return at_; }

  /// Elements up to the end of the bytes; with `marked` up to the end mark of an item of undefined length.
  /// `group`: stop before the first element of another group; -1: read all.
  DicomElements elements(bool marked, int group = -1) {
    DicomElements out;
    out.withTypes_ = withTypes_;
    while (!atEnd() && !onlyPaddingLeft()) {
      if (group >= 0 && nextGroup() != group) return out;
      const DicomTag tag = takeTag();
      if (tag == kItemEnd && marked) {
        takeSize(4);
        return out;
      }
      std::uint32_t size = 0;
      bool types = withTypes_;
      if (withTypes_) {
        const std::string_view type = take(2);
        for (char c : type)
          if (c < 'A' || c > 'Z') throw DicomDamage("an element has no value representation");
        if (isAnyOf(type, {"OB", "OD", "OF", "OL", "OV", "OW", "SQ", "SV", "UC", "UN", "UR", "UT", "UV"})) {
          take(2);
          size = takeSize(4);
        } else {
          size = takeSize(2);
        }
        if (type == "UN" && size == kUndefined) types = false;  // PS3.5 section 6.2.2, note 2
      } else {
        size = takeSize(4);
      }
      if (tag == kPixels && size == kUndefined) {
        out.values_[tag] = {takeFragments(), types};
        out.plainPixels_ = false;
        continue;
      }
      out.values_[tag] = {size == kUndefined ? takeSequence(types) : take(size), types};
    }
    if (marked) throw DicomDamage("it ends inside an item");
    return out;
  }

  /// Items up to the end of the bytes; with `marked` up to the end mark of a sequence of undefined length.
  std::vector<DicomElements> items(bool marked) {
    std::vector<DicomElements> out;
    while (!atEnd()) {
      const DicomTag tag = takeTag();
      const std::uint32_t size = takeSize(4);
      if (tag == kSequenceEnd && marked) return out;
      if (tag != kItem) throw DicomDamage("a sequence holds something else than items");
      if (size == kUndefined) {
        Walk inner(bytes_.substr(at_), withTypes_, depth_ + 1);
        out.push_back(inner.elements(true));
        at_ += inner.at();
      } else {
        out.push_back(Walk(take(size), withTypes_, depth_ + 1).elements(false));
      }
    }
    if (marked) throw DicomDamage("it ends inside a sequence");
    return out;
  }

  std::string_view take(size_t count) {
    if (count > bytes_.size() - at_)
      throw DicomDamage("it ends inside an element: it is damaged or was cut short");
    at_ += count;
    return bytes_.substr(at_ - count, count);
  }

 private:
  DicomTag takeTag() {
    const DicomTag group = takeSize(2);
    return group << 16 | takeSize(2);
  }
  std::uint32_t takeSize(size_t bytes) {
    std::uint32_t size = 0;
    const std::string_view raw = take(bytes);
    for (size_t i = 0; i < bytes; ++i) size |= std::uint32_t(static_cast<unsigned char>(raw[i])) << (8 * i);
    return size;
  }
  int nextGroup() const {
    if (bytes_.size() - at_ < 2) return -1;
    return static_cast<unsigned char>(bytes_[at_]) + 256 * static_cast<unsigned char>(bytes_[at_ + 1]);
  }
  /// Some writers pad the end of a file with zeros.
  bool onlyPaddingLeft() const {
    return withTypes_ && depth_ == 0 && bytes_[at_] == 0 &&
           bytes_.find_first_not_of('\0', at_) == std::string_view::npos;
  }
  /// Compressed pixels: items of plain bytes up to the end mark (PS3.5 section A.4).
  std::string_view takeFragments() {
    const size_t first = at_;
    while (true) {
      const DicomTag tag = takeTag();
      const std::uint32_t size = takeSize(4);
      if (tag == kSequenceEnd) return bytes_.substr(first, at_ - first);
      if (tag != kItem || size == kUndefined)
        throw DicomDamage("its packed pixels hold something else than items");
      take(size);
    }
  }
  /// Bytes of a sequence of undefined length, without its end mark.
  std::string_view takeSequence(bool withTypes) {
    Walk inner(bytes_.substr(at_), withTypes, depth_ + 1);
    inner.items(true);
    constexpr size_t kMark = 8;
    const std::string_view all = take(inner.at());
    return all.substr(0, all.size() - kMark);
  }

  std::string_view bytes_;
  bool withTypes_;
  int depth_;
  size_t at_ = 0;
};

DicomElements DicomElements::ofFile(std::string_view bytes) {
  size_t begin = kPreamble + 4;
  if (bytes.size() < begin || bytes.substr(kPreamble, 4) != "DICM") {
    // Old files have no preamble and begin with group 8; some begin with the meta information.
    const std::string_view group = bytes.substr(0, 2);
    const bool meta = group == std::string_view("\x02\0", 2);
    if (bytes.size() < 8 || (!meta && group != std::string_view("\x08\0", 2)))
      throw DicomDamage("it is no DICOM file");
    if (!meta)
      return Walk(bytes, bytes[4] >= 'A' && bytes[4] <= 'Z' && bytes[5] >= 'A' && bytes[5] <= 'Z')
          .elements(false);
    begin = 0;
  }
  // The file meta information is the elements of group 2; its stated length, (0002,0000), may be
  // missing or wrong.
  Walk head(bytes.substr(begin), true);
  const DicomElements meta = head.elements(false, 2);
  const std::string syntax = meta.text(kTransferSyntax);
  if (syntax == "1.2.840.10008.1.2.2" || syntax == "1.2.840.10008.1.2.1.99")
    throw DicomDamage("it is big endian or deflated as a whole (transfer syntax '" + syntax +
                      "'), which is not read");
  return Walk(bytes.substr(begin + head.at()), syntax != "1.2.840.10008.1.2").elements(false);
}

int DicomElements::number(DicomTag tag) const {
  const auto found = values_.find(tag);
  if (found == values_.end() || found->second.bytes.size() < 2) return -1;
  return static_cast<unsigned char>(found->second.bytes[0]) +
         256 * static_cast<unsigned char>(found->second.bytes[1]);
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

std::vector<DicomElements> DicomElements::items(DicomTag tag) const {
  const auto found = values_.find(tag);
  if (found == values_.end()) return {};
  return Walk(found->second.bytes, found->second.withTypes).items(false);
}

}  // namespace slicemorph
