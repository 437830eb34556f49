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

TEST(StationBoardTest, WhenAStationWasHeardLastOutlivesItsConnection) {
  StationBoard board;
  const Uuid one = Uuid::New();
  EXPECT_EQ(board.HeardMs(one), 0);
  auto connection = board.Enter(one);
  connection->Heard(70);
  connection->Heard(60);
  EXPECT_EQ(board.HeardMs(one), 70);
  connection.reset();
  EXPECT_EQ(board.HeardMs(one), 70);
}

TEST(StationBoardTest, RemarksAreForTheNewestConnectionThatShowsThem) {
  StationBoard board;
  const Uuid one = Uuid::New();
  EXPECT_FALSE(board.ShowsRemarks(one));
  auto older = board.Enter(one, false);
  EXPECT_FALSE(board.ShowsRemarks(one));
  auto newer = board.Enter(one, true);
  EXPECT_TRUE(board.ShowsRemarks(one));
  older.reset();
  newer.reset();
  EXPECT_FALSE(board.ShowsRemarks(one)) << "nobody is there";
}

TEST(StationBoardTest, ConnectionMayOutliveTheBoard) {
  auto board = std::make_unique<StationBoard>();
  auto connection = board->Enter(Uuid::New());
  board.reset();
  connection.reset();
}

}  // namespace
}  // namespace enamel::server
