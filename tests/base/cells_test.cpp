#include "tyndall/base/cells.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace tyndall {
namespace {

TEST(Cells, are_stored_x_fastest) {
  const Cells cells{5, 3, 4};
  EXPECT_EQ(cells.count(), 60u);
  std::size_t next = 0;
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 5; ++i, ++next) {
        ASSERT_EQ(cells.index(i, j, k), next);
        ASSERT_EQ(cells.short_index(i, j, k), static_cast<int>(next));
        const auto [x, y, z] = cells.place(next);
        ASSERT_TRUE(x == i && y == j && z == k);
      }
    }
  }
}

TEST(Cells, of_more_than_32_bits_have_indices) {
  const Cells cells{4096, 2048, 1024};
  EXPECT_EQ(cells.count(), std::size_t{1} << 33);
  EXPECT_EQ(cells.index(4095, 2047, 1023), cells.count() - 1);
  const auto [i, j, k] = cells.place(std::uint64_t{cells.count() - 1});
  EXPECT_TRUE(i == 4095 && j == 2047 && k == 1023);
}

TEST(Cells, nearest_to_a_position_hold_it) {
  const Cells cells{5, 3, 4};
  const auto [i, j, k] = cells.place_of({0.5f, -1, 9}, {10, 6, 8});
  EXPECT_TRUE(i == 4 && j == 0 && k == 3);
  const auto [x, y, z] = cells.place_of({0.15f, 0.4f, 0.3f}, {10, 6, 8});
  EXPECT_TRUE(x == 1 && y == 2 && z == 2);
}

}  // namespace
}  // namespace tyndall
