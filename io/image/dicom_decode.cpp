#include "io/image/dicom_decode.h"

#include "io/whole_file.h"
#include "slicemorph/errors.h"

#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace slicemorph {
namespace {

/// The items that compressed pixels lie in (PS3.5 section A.4), as the file's elements hold them.
gdcm::SmartPointer<gdcm::SequenceOfFragments> fragmentsOf(std::string_view items) {
  gdcm::SmartPointer<gdcm::SequenceOfFragments> fragments = new gdcm::SequenceOfFragments;
  constexpr size_t kHead = 8;
  for (bool table = true; items.size() >= kHead; table = false) {
    std::uint32_t size = 0;
    for (size_t i = 0; i < 4; ++i) size |= std::uint32_t(static_cast<unsigned char>(items[4 + i])) << (8 * i);
    if (items[1] != char(0xff) || size > items.size() - kHead ||
        items.substr(2, 2) != std::string_view("\x00\xe0", 2))
      break;
    // The first item is a table of offsets, mostly empty.
    if (!table) {
      gdcm::Fragment fragment;
      fragment.SetByteValue(items.data() + kHead, size);
      fragments->AddFragment(fragment);
    }
    items.remove_prefix(kHead + size);
  }
  return fragments;
}

/// Unpacks compressed pixels by GDCM, from the pixels alone: its reader of whole files aborts the program where other
/// elements are odd.
DecodedFile decompressed(const DicomFile& file, const DicomElements& data, std::string_view items) {
  const DicomPixels& p = file.pixels;
  gdcm::Image image;
  image.SetNumberOfDimensions(p.frames > 1 ? 3 : 2);
  image.SetDimension(0, unsigned(p.columns)), image.SetDimension(1, unsigned(p.rows));
  if (p.frames > 1) image.SetDimension(2, unsigned(p.frames));
  const auto fragments = fragmentsOf(items);
  image.SetPixelFormat(gdcm::PixelFormat(1, std::uint16_t(p.bits), std::uint16_t(p.bitsUsed),
                                         std::uint16_t(p.highBit), p.isSigned ? 1 : 0));
  image.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
  image.SetTransferSyntax(gdcm::TransferSyntax::GetTSType(data.transferSyntax().c_str()));
  gdcm::DataElement pixels(gdcm::Tag(0x7fe0, 0x0010));
  pixels.SetVR(gdcm::VR::OB);
  pixels.SetValue(*fragments);
  image.SetDataElement(pixels);
  DecodedFile out;
  out.bytes.resize(image.GetBufferLength());
  if (!image.GetBuffer(out.bytes.data()))
    throw IoError(file.path, "its pixels cannot be unpacked (transfer syntax " + data.transferSyntax() + ")");
  const gdcm::PixelFormat& format = image.GetPixelFormat();
  out.layout = {{std::max(1, format.GetBitsAllocated() / 8),
                 format.GetPixelRepresentation() ? RawType::kSigned : RawType::kUnsigned},
                format.GetBitsStored(),
                format.GetHighBit()};
  return out;
}

/// Pixels that are not compressed, of a deflated or big endian file.
DecodedFile unpacked(const DicomFile& file, const DicomElements& data, std::string_view stored) {
  DecodedFile out;
  out.layout = layoutOf(file.pixels);
  out.bytes.assign(stored.begin(), stored.end());
  if (!data.bigEndian()) return out;
  // Pixels of 8 bits and less lie in words of 16 (OW) or in bytes (OB).
  const int bits = file.pixels.bits, size = bits > 8 ? bits / 8 : data.type(file.pixels.tag) == "OW" ? 2 : 1;
  swapBytes(out.bytes.data(), out.bytes.size() / size_t(size), size);
  return out;
}

}  // namespace

PixelLayout layoutOf(const DicomPixels& p) {
  const RawType::Kind kind = p.kind != DicomPixels::kWhole ? RawType::kFloat
                             : p.isSigned                  ? RawType::kSigned
                                                           : RawType::kUnsigned;
  return {{std::max(1, p.bits / 8), kind}, p.bitsUsed, p.highBit};
}

DecodedFile decodeFile(const DicomFile& file) {
  const std::string bytes = readWholeFile(file.path);
  try {
    const DicomElements data = DicomElements::ofFile(bytes);
    const std::string_view stored = data.bytes(file.pixels.tag);
    DecodedFile out = data.plainPixels() ? unpacked(file, data, stored) : decompressed(file, data, stored);
    const DicomPixels& p = file.pixels;
    const size_t needed = (size_t(p.columns) * size_t(p.rows) * size_t(p.frames) *
                               size_t(p.bits == 1 ? 1 : 8 * out.layout.type.bytes) +
                           7) /
                          8;
    if (out.bytes.size() < needed)
      throw IoError(file.path, "its pixels unpack to " + std::to_string(out.bytes.size()) + " bytes, " +
                                   std::to_string(needed) + " are needed");
    return out;
  } catch (const IoError&) {
    throw;
  } catch (const std::exception& error) {
    throw IoError(file.path, std::string("its pixels cannot be unpacked: ") + error.what());
  }
}

WithoutTerminal::WithoutTerminal() {
  gdcm::Trace::WarningOff(), gdcm::Trace::ErrorOff(), gdcm::Trace::DebugOff();
  std::fflush(stderr);
  const int nothing = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nothing < 0) return;
  kept_ = ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
  if (kept_ >= 0) ::dup2(nothing, STDERR_FILENO);
  ::close(nothing);
}

WithoutTerminal::~WithoutTerminal() {
  if (kept_ < 0) return;
  std::fflush(stderr);
  ::dup2(kept_, STDERR_FILENO);
  ::close(kept_);
}

}  // namespace slicemorph
