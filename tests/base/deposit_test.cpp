#include "tyndall/base/deposit.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace tyndall {
namespace {

TEST(Deposit, units_are_2_to_the_minus_24_rounded_to_nearest) {
  EXPECT_EQ(to_units(1.0f), 1 << 24);
  EXPECT_EQ(to_units(-1.0f), -(1 << 24));
  EXPECT_EQ(to_units(0x1p-24f), 1);
  EXPECT_EQ(to_units(0x1p-25f), 0);    // a tie, to even
  EXPECT_EQ(to_units(0x1.8p-24f), 2);  // the other way
  EXPECT_EQ(to_units(-0x1.8p-24f), -2);
  EXPECT_EQ(to_units(0x1.1p-25f), 1);
  EXPECT_EQ(to_units(0.0f), 0);
}

TEST(Deposit, threads_lose_nothing) {
  std::int64_t tally = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&tally, t] {
      for (int i = 0; i < 100000; ++i) deposit(tally, t % 2 == 0 ? 3 : -1);
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(tally, 400000);
}

}  // namespace
}  // namespace tyndall
