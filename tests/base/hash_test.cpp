#include "tyndall/base/hash.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <random>
#include <set>

namespace tyndall {
namespace {

std::uint64_t hash_of(std::initializer_list<std::uint64_t> words) {
  Hasher hasher;
  for (std::uint64_t w : words) hasher.add(w);
  return hasher.value();
}

// splitmix64's published sequence for seed 1234567.
TEST(Hash, mix64_is_the_finaliser_of_splitmix64) {
  const std::uint64_t step = 0x9e3779b97f4a7c15u;
  EXPECT_EQ(mix64(1234567 + step), 6457827717110365317u);
  EXPECT_EQ(mix64(1234567 + 2 * step), 3203168211198807973u);
  EXPECT_EQ(mix64(1234567 + 3 * step), 9817491932198370423u);
}

TEST(Hash, every_bit_of_a_word_changes_half_of_the_hash) {
  std::mt19937_64 random(1);
  for (int bit = 0; bit < 64; ++bit) {
    int changed = 0;
    for (int i = 0; i < 200; ++i) {
      const std::uint64_t word = random();
      changed += std::popcount(hash_of({word, 5}) ^ hash_of({word ^ (std::uint64_t{1} << bit), 5}));
    }
    EXPECT_NEAR(changed / 200.0, 32, 32 * 0.05) << bit;
  }
}

TEST(Hash, order_count_and_boundaries_matter) {
  EXPECT_NE(hash_of({1, 2}), hash_of({2, 1}));
  EXPECT_NE(hash_of({0}), hash_of({0, 0}));
  EXPECT_NE(hash_of({}), hash_of({0}));
  const std::array<std::int64_t, 4> v{1, 2, 3, 4};
  Hasher two_and_two, three_and_one;
  two_and_two.add_all(v.data(), 2);
  two_and_two.add_all(v.data() + 2, 2);
  three_and_one.add_all(v.data(), 3);
  three_and_one.add_all(v.data() + 3, 1);
  EXPECT_NE(two_and_two.value(), three_and_one.value());
}

TEST(Hash, many_small_words_do_not_collide) {
  std::set<std::uint64_t> seen;
  for (std::uint64_t a = 0; a < 300; ++a) {
    for (std::uint64_t b = 0; b < 300; ++b) seen.insert(hash_of({a, b}));
  }
  EXPECT_EQ(seen.size(), 90000u);
}

TEST(Hash, negative_tallies_are_hashed_by_their_bits) {
  const std::int64_t minus_one = -1;
  Hasher a, b;
  a.add_all(&minus_one, 1);
  b.add(1);
  b.add(0xffffffffffffffffu);
  EXPECT_EQ(a.value(), b.value());
}

}  // namespace
}  // namespace tyndall
