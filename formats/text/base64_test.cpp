#include "formats/text/base64.h"

#include <string_view>

#include <gtest/gtest.h>

namespace t4d::formats {
namespace {

TEST(Base64, EncodesTheTestVectorsOfRfc4648) {
  const auto encoded = [](std::string_view text) {
    return base64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  };
  EXPECT_EQ(encoded(""), "");
  EXPECT_EQ(encoded("f"), "Zg==");
  EXPECT_EQ(encoded("fo"), "Zm8=");
  EXPECT_EQ(encoded("foo"), "Zm9v");
  EXPECT_EQ(encoded("foob"), "Zm9vYg==");
  EXPECT_EQ(encoded("fooba"), "Zm9vYmE=");
  EXPECT_EQ(encoded("foobar"), "Zm9vYmFy");
  EXPECT_EQ(encoded("\xff\xfe\xfb"), "//77");
}

TEST(Base64, DecodesWhatItEncodesAndTextsInARow) {
  std::string bytes;
  for (int i = 0; i < 300; ++i) {
    bytes += static_cast<char>(i * 7);
    const std::string text =
        base64({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    EXPECT_EQ(fromBase64(text), bytes);
    EXPECT_EQ(fromBase64(" " + text.substr(0, 5) + "\n" +
                         text.substr(std::min<std::size_t>(5, text.size()))),
              bytes);
    EXPECT_EQ(fromBase64(text + "Zm8="), bytes + "fo");
    EXPECT_EQ(fromBase64(text.substr(1)), std::nullopt);
    EXPECT_EQ(fromBase64(text + "Zm8=", bytes.size()), bytes);
  }
  EXPECT_EQ(fromBase64("Zm9*"), std::nullopt);
  EXPECT_EQ(fromBase64("Z==="), std::nullopt);
  EXPECT_EQ(fromBase64("Zg=v"), std::nullopt);
}

}  // namespace
}  // namespace t4d::formats
