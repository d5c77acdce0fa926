#include "model/number.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace t4d::model {
namespace {

TEST(Number, IsTheWholeText) {
  EXPECT_EQ(numberIn<double>("1.5"), 1.5);
  EXPECT_EQ(numberIn<double>("-1e3"), -1000);
  EXPECT_EQ(numberIn<double>("inf"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(numberIn<std::uint8_t>("fF", 16), 255);
  for (const char* text :
       {"", " 1", "1 ", "+1", "1,5", "0x10", "-", ".", "e5", "1e999", "1e-999"}) {
    EXPECT_FALSE(numberIn<double>(text)) << text;
  }
  EXPECT_FALSE(numberIn<std::uint8_t>("256"));
  EXPECT_FALSE(numberIn<std::uint64_t>("-1"));
}

TEST(Number, IsTakenFromTheBeginning) {
  std::string_view text = "12,5e2;x";
  EXPECT_EQ(takeNumber<int>(text), 12);
  EXPECT_EQ(text, ",5e2;x");
  EXPECT_FALSE(takeNumber<int>(text));
  text.remove_prefix(1);
  EXPECT_EQ(takeNumber<double>(text, std::chars_format::fixed), 5);
  EXPECT_EQ(text, "e2;x");
}

TEST(Number, HasOnePlusSignAtMost) {
  EXPECT_EQ(withoutPlus("+1"), "1");
  for (const char* text : {"", "+", "+-1", "++1", "1"}) EXPECT_EQ(withoutPlus(text), text);
}

TEST(Number, IsReadBackBitForBit) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 10'000; ++i) {
    const auto bits = random();
    double number = 0;
    std::memcpy(&number, &bits, sizeof number);
    std::string text;
    appendNumber(text, number);
    if (std::isnan(number)) continue;
    EXPECT_EQ(numberIn<double>(text), number) << text;
  }
}

}  // namespace
}  // namespace t4d::model
