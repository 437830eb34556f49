// Stations in use, with the tooth under each tool: a part of the page of its own.
export { LivePage } from "../features/live/live_page";
export { WatchPage } from "../features/live/watch_page";
