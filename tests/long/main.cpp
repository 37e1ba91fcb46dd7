/// \file
/// The long tests; with --record, the pictures that tests/golden/update_blocks.sh records.
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
