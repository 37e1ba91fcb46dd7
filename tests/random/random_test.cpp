#include "tyndall/random/random.h"

#include <Random123/philox.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "support/statistics.h"

namespace tyndall {
namespace {

using Words = std::array<std::uint32_t, 4>;

Words words(RandomBlock r) { return {r.a, r.b, r.c, r.d}; }

// A stream whose counter and key are the given words.
Words philox(Words counter, std::uint32_t key_low, std::uint32_t key_high) {
  const auto both = [](std::uint32_t low, std::uint32_t high) {
    return std::uint64_t{high} << 32 | low;
  };
  const RandomStream stream{both(key_low, key_high), both(counter[0], counter[1]),
                            static_cast<Domain>(counter[3] / 16)};
  return words(stream.block(counter[2], static_cast<Purpose>(counter[3] % 16)));
}

// philox4x32 10 in the kat_vectors of Random123.
TEST(Random, blocks_are_the_known_answers_of_philox4x32_10) {
  EXPECT_EQ(philox({0, 0, 0, 0}, 0, 0), (Words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  const std::uint32_t f = 0xffffffff;
  EXPECT_EQ(philox({f, f, f, f}, f, f), (Words{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, 0xa4093822, 0x299f31d0),
            (Words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

// Part of the format: a change here is a new arithmetic version.
TEST(Random, counters_are_index_event_and_purpose) {
  const std::uint64_t seed = 0x299f31d0a4093822, index = 0x85a308d3243f6a88;
  for (const Domain domain : {Domain::photon, Domain::pixel_sample, Domain::matter}) {
    for (const Purpose purpose :
         {Purpose::emission, Purpose::aim, Purpose::walk, Purpose::scatter}) {
      const std::uint32_t last =
          static_cast<std::uint32_t>(domain) * 16 + static_cast<std::uint32_t>(purpose);
      const philox4x32_ctr_t counter = {{0x243f6a88, 0x85a308d3, 77, last}};
      const philox4x32_key_t key = {{0xa4093822, 0x299f31d0}};
      const philox4x32_ctr_t r = philox4x32_R(10, counter, key);
      EXPECT_EQ(words(RandomStream{seed, index, domain}.block(77, purpose)),
                (Words{r.v[0], r.v[1], r.v[2], r.v[3]}));
    }
  }
}

TEST(Random, no_two_of_seed_index_domain_event_and_purpose_share_a_block) {
  std::set<Words> seen;
  std::size_t drawn = 0;
  const std::uint64_t high = std::uint64_t{1} << 32;
  for (const std::uint64_t seed :
       {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{2}, high, high + 1}) {
    for (const std::uint64_t index :
         {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{16}, high, high + 1}) {
      for (const Domain domain : {Domain::photon, Domain::pixel_sample, Domain::matter}) {
        for (const Purpose purpose :
             {Purpose::emission, Purpose::aim, Purpose::walk, Purpose::scatter}) {
          for (const std::uint32_t event : {0u, 1u, 2u, 16u, 0xffffffffu}) {
            seen.insert(words(RandomStream{seed, index, domain}.block(event, purpose)));
            ++drawn;
          }
        }
      }
    }
  }
  EXPECT_EQ(seen.size(), drawn);
}

TEST(Random, numbers_do_not_depend_on_the_order_of_drawing) {
  std::vector<Words> forwards, backwards;
  for (std::uint64_t i = 0; i < 50; ++i) {
    const RandomStream stream{9, i, Domain::photon};
    for (std::uint32_t e = 0; e < 50; ++e)
      forwards.push_back(words(stream.block(e, Purpose::walk)));
  }
  for (std::uint64_t i = 50; i-- > 0;) {
    for (std::uint32_t e = 50; e-- > 0;) {
      backwards.push_back(words(RandomStream{9, i, Domain::photon}.block(e, Purpose::walk)));
    }
  }
  std::reverse(backwards.begin(), backwards.end());
  EXPECT_EQ(forwards, backwards);
}

TEST(Random, uniforms_lie_within_0_and_1_and_keep_all_32_bits_near_0) {
  EXPECT_EQ(uniform(0), 0x1p-33f);
  EXPECT_EQ(uniform(1), 3 * 0x1p-33f);
  EXPECT_EQ(uniform(0xffffffffu), 1.0f - 0x1p-24f);
  EXPECT_LT(uniform(0xffffff7fu), 1.0f);
  for (std::uint32_t k = 0; k < 1 << 22; ++k)
    ASSERT_EQ(uniform(k), (2 * static_cast<float>(k) + 1) * 0x1p-33f);
  float last = 0;
  for (std::uint64_t k = 0; k < std::uint64_t{1} << 32; k += 4093) {
    const float u = uniform(static_cast<std::uint32_t>(k));
    ASSERT_GE(u, last);
    ASSERT_LT(u, 1.0f);
    ASSERT_NEAR(u, (static_cast<double>(k) + 0.5) * 0x1p-32, 0x1p-24);
    last = u;
  }
}

TEST(Random, symmetric_uniforms_are_never_0_a_half_or_1_and_mirror_exactly) {
  EXPECT_EQ(uniform_symmetric(0), 0x1p-24f);
  EXPECT_EQ(uniform_symmetric(0xffffffffu), 1.0f - 0x1p-24f);
  EXPECT_LT(uniform_symmetric(0x7fffffffu), 0.5f);
  EXPECT_GT(uniform_symmetric(0x80000000u), 0.5f);
  float last = 0;
  for (std::uint32_t k = 0; k < 1u << 23; ++k) {
    const float u = uniform_symmetric(k << 9);
    ASSERT_GT(u, last);
    ASSERT_NE(1.0f - 2.0f * u, 0.0f);
    ASSERT_EQ(u + uniform_symmetric(~(k << 9)), 1.0f);
    last = u;
  }
}

TEST(Random, exponential_reaches_from_2_to_the_minus_24_to_22_point_9) {
  EXPECT_EQ(exponential(0xffffffffu), 0x1p-24f);
  EXPECT_NEAR(exponential(0), 33 * std::log(2.0), 2e-6);
  EXPECT_LT(exponential(0), 22.9f);
  float last = 23;
  for (std::uint64_t k = 0; k < std::uint64_t{1} << 32; k += 16381) {
    const float tau = exponential(static_cast<std::uint32_t>(k));
    ASSERT_GE(tau, 0x1p-24f);
    ASSERT_LE(tau, last + 4e-6f);
    last = tau;
  }
}

// The words of one block, of neighbouring photons, events and purposes.
template <class Draw>
void expect_uniform(const char* what, Draw draw) {
  const int n = 200000;
  std::vector<double> p;
  std::vector<std::vector<double>> numbers(4);
  std::vector<std::int64_t> pairs(4 * 256), neighbours(256), bits(32), shared(32);
  Words before{};
  for (int i = 0; i < n; ++i) {
    const Words w = draw(i);
    for (std::size_t j = 0; j < 4; ++j) {
      numbers[j].push_back(uniform(w[j]));
      ++pairs[256 * j + (w[j] >> 28) * 16 + (w[(j + 1) % 4] >> 28)];
    }
    if (i % 2 == 1) ++neighbours[(before[0] >> 28) * 16 + (w[0] >> 28)];
    for (int b = 0; b < 32; ++b) {
      bits[b] += w[1] >> b & 1;
      shared[b] += (w[2] ^ before[2]) >> b & 1;
    }
    before = w;
  }
  for (std::vector<double>& u : numbers) {
    p.push_back(test::kolmogorov_smirnov_test(std::move(u), [](double x) { return x; }));
  }
  for (std::size_t j = 0; j < 4; ++j) {
    p.push_back(test::chi_square_test({pairs.begin() + 256 * static_cast<std::ptrdiff_t>(j),
                                       pairs.begin() + 256 * static_cast<std::ptrdiff_t>(j + 1)})
                    .p);
  }
  p.push_back(test::chi_square_test(neighbours).p);
  for (int b = 0; b < 32; ++b) {
    p.push_back(test::proportion_p(bits[b], n, 0.5));
    p.push_back(test::proportion_p(shared[b], n, 0.5));
  }
  EXPECT_GT(test::sidak_p(p), 1e-4) << what;
}

TEST(Random, words_are_uniform_and_uncorrelated_along_every_counter) {
  expect_uniform("photons", [](int i) {
    return words(
        RandomStream{1, static_cast<std::uint64_t>(i), Domain::photon}.block(0, Purpose::emission));
  });
  expect_uniform("pixel samples far apart", [](int i) {
    return words(RandomStream{1, static_cast<std::uint64_t>(i) << 32, Domain::pixel_sample}.block(
        1, Purpose::walk));
  });
  expect_uniform("events", [](int i) {
    return words(
        RandomStream{1, 5, Domain::photon}.block(static_cast<std::uint32_t>(i), Purpose::walk));
  });
  expect_uniform("purposes", [](int i) {
    const RandomStream stream{1, static_cast<std::uint64_t>(i / 4), Domain::photon};
    return words(stream.block(3, static_cast<Purpose>(i % 4)));
  });
  expect_uniform("seeds", [](int i) {
    return words(
        RandomStream{static_cast<std::uint64_t>(i), 5, Domain::matter}.block(0, Purpose::emission));
  });
}

TEST(Random, exponentials_are_exponential) {
  std::vector<double> tau;
  for (std::uint64_t i = 0; i < 300000; ++i) {
    tau.push_back(exponential(RandomStream{3, i, Domain::photon}.block(1, Purpose::walk).b));
  }
  EXPECT_GT(test::kolmogorov_smirnov_test(tau, [](double x) { return -std::expm1(-x); }), 1e-4);
}

}  // namespace
}  // namespace tyndall
