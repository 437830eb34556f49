import assert from "node:assert/strict";
import { test } from "node:test";
import { memberTitle } from "./profile_text";

test("a number of a profile is called by its words and its unit", () => {
  assert.equal(memberTitle("max_stiffness_mn_per_mm"), "Max stiffness (mN/mm)");
  assert.equal(memberTitle("damping_mn_s_per_m"), "Damping (mN s/m)");
  assert.equal(memberTitle("rate_hz"), "Rate (Hz)");
  assert.equal(memberTitle("bus_delay_ticks"), "Bus delay (ticks)");
  assert.equal(memberTitle("something_else"), "Something else");
  assert.equal(memberTitle("something_else_mn"), "Something else (mN)");
});
