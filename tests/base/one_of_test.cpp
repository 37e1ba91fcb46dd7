#include "tyndall/base/one_of.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace tyndall::test {
namespace {

struct Small {
  char c = 'a';
};
struct Wide {
  double values[3] = {1, 2, 3};
};
using Any = OneOf<Small, Wide, int>;

TEST(OneOf, is_the_first_type_until_it_is_given_another) {
  Any any;
  ASSERT_TRUE(any.is<Small>());
  EXPECT_EQ(any.as<Small>().c, 'a');
  any = Wide{{4, 5, 6}};
  EXPECT_FALSE(any.is<Small>());
  ASSERT_TRUE(any.is<Wide>());
  EXPECT_EQ(any.as<Wide>().values[2], 6);
  any.as<Wide>().values[2] = 7;
  const Any copy = any;
  EXPECT_EQ(copy.as<Wide>().values[2], 7);
}

TEST(OneOf, visits_the_value_that_it_holds) {
  const auto size = [](const auto& value) { return sizeof value; };
  const Any small = Small{}, wide = Wide{};
  EXPECT_EQ(small.visit(size), sizeof(Small));
  EXPECT_EQ(wide.visit(size), sizeof(Wide));
  Any any = 3;
  int visits = 0;
  any.visit([&](auto& value) {
    ++visits;
    value = {};
  });
  EXPECT_EQ(visits, 1);
  EXPECT_EQ(any.as<int>(), 0);
}

TEST(OneOf, is_as_large_and_aligned_as_its_types_and_trivially_copyable) {
  static_assert(std::is_trivially_copyable_v<Any>);
  static_assert(alignof(Any) == alignof(Wide));
  static_assert(sizeof(Any) <= sizeof(Wide) + alignof(Wide));
  Any any = Wide{};
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(&any.as<Wide>()) % alignof(Wide), 0u);
}

}  // namespace
}  // namespace tyndall::test
