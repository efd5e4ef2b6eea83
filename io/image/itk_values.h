#pragma once

#include "io/image/raw_values.h"
#include "slicemorph/errors.h"

#include <itkImageIOBase.h>

#include <string>

namespace slicemorph {

/// From ITK's name of a number type. Throws IoError where it is none.
inline RawType rawTypeOf(const std::string& path, itk::ImageIOBase::IOComponentEnum component) {
  using Type = itk::ImageIOBase::IOComponentEnum;
  switch (component) {
    case Type::UCHAR:
      return {1, RawType::kUnsigned};
    case Type::CHAR:
      return {1, RawType::kSigned};
    case Type::USHORT:
      return {2, RawType::kUnsigned};
    case Type::SHORT:
      return {2, RawType::kSigned};
    case Type::UINT:
      return {4, RawType::kUnsigned};
    case Type::INT:
      return {4, RawType::kSigned};
    case Type::ULONG:
    case Type::ULONGLONG:
      return {8, RawType::kUnsigned};
    case Type::LONG:
    case Type::LONGLONG:
      return {8, RawType::kSigned};
    case Type::FLOAT:
      return {4, RawType::kFloat};
    case Type::DOUBLE:
      return {8, RawType::kFloat};
    default:
      break;
  }
  throw IoError(path, "its voxels are no plain numbers");
}

}  // namespace slicemorph
