/// \file
/// Runs the long tests; with --record prints the pictures for tests/golden/update_blocks.sh.
#include <gtest/gtest.h>

#include <string>

#include "support/accuracy.h"

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  if (argc == 2 && std::string(argv[1]) == "--record") {
    tyndall::test::print_record();
    return 0;
  }
  return RUN_ALL_TESTS();
}
