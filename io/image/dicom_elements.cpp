#include "io/image/dicom_elements.h"

#include <zlib.h>

#include <algorithm>

namespace slicemorph {

namespace {

constexpr std::uint32_t kUndefined = 0xffffffff;
constexpr DicomTag kItem = 0xfffee000, kItemEnd = 0xfffee00d, kSequenceEnd = 0xfffee0dd,
                   kTransferSyntax = 0x00020010, kPixels = 0x7fe00010;
constexpr size_t kPreamble = 128;  // bytes before "DICM", PS3.10 section 7.1
constexpr int kMostNested = 32;    // bounds the recursion over sequences of a damaged or hostile file
// Bounds what a small hostile file unpacks to, 1032 times its size at most; far above any deflated image there is.
constexpr size_t kMostInflated = size_t(1) << 31;

bool isAnyOf(std::string_view type, std::initializer_list<const char*> types) {
  for (const char* t : types)
    if (type == t) return true;
  return false;
}

}  // namespace

/// Parses bytes element by element. Everything throws DicomDamage.
class DicomElements::Walk {
 public:
  Walk(std::string_view bytes, bool withTypes, bool bigEndian, int depth = 0)
      : bytes_(bytes), withTypes_(withTypes), bigEndian_(bigEndian), depth_(depth) {
    if (depth > kMostNested) throw DicomDamage("its sequences are nested too deeply");
  }

  bool atEnd() const { return at_ == bytes_.size(); }
  size_t at() const { return at_; }

  DicomElements elements(bool marked, int group = -1) {
    DicomElements out;
    read(out, marked, group);
    return out;
  }

  /// Elements up to the end of the bytes; with `marked` up to the end mark of an item of undefined length.
  /// `group`: stop before the first element of another group; -1: read all. What was read before an error stays.
  void read(DicomElements& out, bool marked, int group = -1) {
    out.withTypes_ = withTypes_, out.bigEndian_ = bigEndian_;
    while (!atEnd() && !onlyPaddingLeft()) {
      if (group >= 0 && nextGroup() != group) return;
      const DicomTag tag = takeTag();
      if (tag == kItemEnd && marked) {
        takeSize(4);
        return;
      }
      std::uint32_t size = 0;
      Value value;
      value.withTypes = withTypes_;
      if (withTypes_) {
        const std::string_view type = take(2);
        std::copy(type.begin(), type.end(), value.type);
        for (char c : type)
          if (c < 'A' || c > 'Z') throw DicomDamage("an element has no value representation");
        if (isAnyOf(type, {"OB", "OD", "OF", "OL", "OV", "OW", "SQ", "SV", "UC", "UN", "UR", "UT", "UV"})) {
          take(2);
          size = takeSize(4);
        } else {
          size = takeSize(2);
        }
        if (type == "UN") value.withTypes = false;  // PS3.5 section 6.2.2, note 2
      } else {
        size = takeSize(4);
      }
      if (tag == kPixels && size == kUndefined) {
        value.bytes = takeFragments();
        out.plainPixels_ = false;
      } else {
        value.bytes = size == kUndefined ? takeSequence(value.withTypes) : take(size);
      }
      out.values_[tag] = value;
    }
    if (marked) throw DicomDamage("it ends inside an item");
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
        Walk inner(bytes_.substr(at_), withTypes_, bigEndian_, depth_ + 1);
        out.push_back(inner.elements(true));
        at_ += inner.at();
      } else {
        out.push_back(Walk(take(size), withTypes_, bigEndian_, depth_ + 1).elements(false));
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
    for (size_t i = 0; i < bytes; ++i)
      size |= std::uint32_t(static_cast<unsigned char>(raw[i])) << (8 * (bigEndian_ ? bytes - 1 - i : i));
    return size;
  }
  int nextGroup() {
    if (bytes_.size() - at_ < 2) return -1;
    const int group = int(takeSize(2));
    at_ -= 2;
    return group;
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
    Walk inner(bytes_.substr(at_), withTypes, bigEndian_, depth_ + 1);
    inner.items(true);
    constexpr size_t kMark = 8;
    const std::string_view all = take(inner.at());
    return all.substr(0, all.size() - kMark);
  }

  std::string_view bytes_;
  bool withTypes_, bigEndian_;
  int depth_;
  size_t at_ = 0;
};

namespace {

bool beginsWithGroup(std::string_view bytes, char group) {
  return bytes.size() >= 8 && bytes[0] == group && bytes[1] == 0;
}

/// Whether the first element has a value representation.
bool hasTypes(std::string_view bytes) {
  const auto isLetter = [](char c) { return c >= 'A' && c <= 'Z'; };
  return bytes.size() >= 6 && isLetter(bytes[4]) && isLetter(bytes[5]);
}

/// Unpacks a deflated data set (PS3.5 section A.5: without zlib's header).
std::string inflated(std::string_view packed) {
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) throw DicomDamage("it cannot be unpacked");
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = uInt(packed.size());
  std::string out;
  int state = Z_OK;
  while (state == Z_OK) {
    const size_t done = out.size(),
                 step = std::min(std::max<size_t>(1 << 16, done), kMostInflated + 1 - done);
    out.resize(done + step);
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + done);
    stream.avail_out = uInt(step);
    state = inflate(&stream, Z_NO_FLUSH);
    out.resize(done + step - stream.avail_out);
    if (out.size() > kMostInflated) break;
    if (stream.avail_in == 0 && stream.avail_out > 0) break;
  }
  inflateEnd(&stream);
  if (out.size() > kMostInflated) throw DicomDamage("its packed data unpack to more than 2 GB");
  if (state != Z_STREAM_END) throw DicomDamage("its packed data are damaged or were cut short");
  return out;
}

}  // namespace

DicomElements DicomElements::ofFile(std::string_view bytes) {
  std::string damage;
  DicomElements out = startOfFile(bytes, damage);
  if (!damage.empty()) throw DicomDamage(damage);
  return out;
}

DicomElements DicomElements::startOfFile(std::string_view bytes, std::string& damage) {
  damage.clear();
  DicomElements out;
  try {
    const bool marked = bytes.size() >= kPreamble + 4 && bytes.substr(kPreamble, 4) == "DICM";
    std::string_view data = bytes;
    // Old files have no preamble, and begin with the meta information of group 2 or with group 8.
    if (marked || beginsWithGroup(bytes, 2)) {
      // The file meta information is the elements of group 2; its stated length, (0002,0000), may be
      // missing or wrong.
      if (marked) data.remove_prefix(kPreamble + 4);
      Walk head(data, true, false);
      out.transferSyntax_ = head.elements(false, 2).text(kTransferSyntax);
      data.remove_prefix(head.at());
    } else if (!beginsWithGroup(bytes, 8) &&
               !(bytes.size() >= 8 && bytes[0] == 0 && bytes[1] == 8 && hasTypes(bytes))) {
      throw DicomDamage("it is no DICOM file");
    }
    const bool deflated = out.transferSyntax_ == "1.2.840.10008.1.2.1.99";
    if (deflated) {
      out.inflated_ = std::make_shared<const std::string>(inflated(data));
      data = *out.inflated_;
    }
    // What stands in the file, since files without or with a wrong transfer syntax are common.
    const bool bigEndian = data.size() >= 2 && data[0] == 0 && data[1] != 0;
    Walk(data, hasTypes(data), bigEndian).read(out, false);
  } catch (const DicomDamage& found) {
    damage = found.what();
  }
  return out;
}

std::vector<DicomElements> DicomElements::items(DicomTag tag) const {
  const auto found = values_.find(tag);
  if (found == values_.end()) return {};
  return Walk(found->second.bytes, found->second.withTypes, bigEndian_).items(false);
}

DicomElements DicomElements::item(DicomTag tag) const {
  std::vector<DicomElements> all = items(tag);
  return all.empty() ? DicomElements() : std::move(all[0]);
}

}  // namespace slicemorph
