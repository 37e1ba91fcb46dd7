/// \file
/// Any number of ranks gives the same bits as one. Here the ranks are threads.
#include <gtest/gtest.h>

#include <atomic>
#include <barrier>
#include <cstring>
#include <mutex>
#include <thread>
#include <vector>

#include "support/scenes.h"
#include "tyndall/render/communicator.h"
#include "tyndall/render/error.h"

namespace tyndall::test {
namespace {

/// The shared state of the ranks.
struct Machine {
  explicit Machine(int n) : size(n), all(n) {}
  const int size;
  std::barrier<> all;
  void* told = nullptr;
  std::vector<std::int64_t> sums;
  std::mutex mutex;
  std::atomic<std::uint64_t> tickets{0};
};

class ThreadRank final : public Communicator {
 public:
  ThreadRank(Machine& machine, int rank) : machine_(machine), rank_(rank) {}
  int rank() const override { return rank_; }
  int size() const override { return machine_.size; }
  int local_rank() const override { return rank_; }
  int local_size() const override { return machine_.size; }
  void broadcast(void* bytes, std::size_t size) override {
    if (rank_ == 0) machine_.told = bytes;
    machine_.all.arrive_and_wait();
    if (rank_ > 0 && size > 0) std::memcpy(bytes, machine_.told, size);
    machine_.all.arrive_and_wait();
  }
  void add_up(std::int64_t* values, std::size_t count) override {
    if (rank_ == 0) machine_.sums.assign(values, values + count);
    machine_.all.arrive_and_wait();
    if (rank_ > 0) {
      const std::lock_guard lock(machine_.mutex);
      for (std::size_t i = 0; i < count; ++i) machine_.sums[i] += values[i];
    }
    machine_.all.arrive_and_wait();
    if (rank_ == 0) std::copy(machine_.sums.begin(), machine_.sums.end(), values);
  }
  std::uint64_t next_ticket() override { return machine_.tickets++; }
  void abort(int) override { std::abort(); }

 private:
  Machine& machine_;
  const int rank_;
};

/// \param others the scene of the ranks other than 0
RenderResult render_by(int n, const Scene& scene, const Scene& others,
                       const RenderOptions& options = {}) {
  Machine machine(n);
  std::vector<std::thread> threads;
  for (int r = 1; r < n; ++r) {
    threads.emplace_back([&, r] {
      ThreadRank rank(machine, r);
      const auto local = make_cpu_backend(1);
      serve(others, *local, rank);
    });
  }
  struct Join {
    std::vector<std::thread>& threads;
    ~Join() {
      for (std::thread& thread : threads) thread.join();
    }
  } const join{threads};
  ThreadRank rank(machine, 0);
  const auto local = make_cpu_backend(1);
  const auto all = make_distributed_backend(*local, rank);
  return render(scene, *all, options);
}

TEST(Distributed, any_number_of_ranks_gives_one_result) {
  const Scene scene = quick();
  const RenderResult alone = render(scene, *make_cpu_backend());
  RenderOptions options;
  for (const int n : {1, 2, 3, 5}) {
    for (const std::uint64_t batch : {0u, 13u}) {
      SCOPED_TRACE(testing::Message() << n << " ranks, batches of " << batch);
      options.batch = batch;
      expect_same(render_by(n, scene, scene, options), alone);
    }
  }
}

TEST(Distributed, ranks_that_read_another_scene_are_found_out) {
  Scene other = quick();
  other.medium.components[0].extinction *= 1.0001;
  try {
    render_by(3, quick(), other);
    ADD_FAILURE() << "rendered";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("2 of 3 ranks read another scene"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace tyndall::test
