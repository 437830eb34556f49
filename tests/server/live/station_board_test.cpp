#include "server/live/station_board.h"

#include <gtest/gtest.h>

namespace enamel::server {
namespace {

TEST(StationBoardTest, StationIsConnectedUntilItsLastConnectionEnds) {
  StationBoard board;
  const Uuid one = Uuid::New(), other = Uuid::New();
  EXPECT_FALSE(board.Connected(one));
  auto first = board.Enter(one);
  auto second = board.Enter(one);
  EXPECT_TRUE(board.Connected(one));
  EXPECT_FALSE(board.Connected(other));
  first.reset();
  EXPECT_TRUE(board.Connected(one)) << "the newer connection is still there";
  second.reset();
  EXPECT_FALSE(board.Connected(one));
}

TEST(StationBoardTest, ConnectionMayOutliveTheBoard) {
  auto board = std::make_unique<StationBoard>();
  auto connection = board->Enter(Uuid::New());
  board.reset();
  connection.reset();
}

}  // namespace
}  // namespace enamel::server
