#pragma once

#include <cstdint>

#include <expat.h>

/// Where Expat is in a text. Its functions of 64 bits are new in 2.9, where those before them are
/// deprecated; whichever there is, is called.
namespace t4d::platform {

/// The line, from 1.
template <class Parser>
std::uint64_t xmlLine(Parser* parser) {
  if constexpr (requires { XML_GetCurrentLineNumber64(parser); }) {
    return XML_GetCurrentLineNumber64(parser);
  } else {
    return XML_GetCurrentLineNumber(parser);
  }
}

/// The byte, from 0.
template <class Parser>
std::uint64_t xmlByte(Parser* parser) {
  if constexpr (requires { XML_GetCurrentByteIndex64(parser); }) {
    return static_cast<std::uint64_t>(XML_GetCurrentByteIndex64(parser));
  } else {
    return static_cast<std::uint64_t>(XML_GetCurrentByteIndex(parser));
  }
}

}  // namespace t4d::platform
