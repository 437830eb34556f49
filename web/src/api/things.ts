import { ok } from "../base/result";
import { type ApiResult, type Http, segment } from "./http";
import type {
  AuditEntry,
  Backups,
  Calibration,
  EnrolCode,
  Job,
  ListedDevice,
  MadeEnrolCode,
  Profile,
  ProfileDetail,
  ProfileJudgement,
  ProfileReport,
  ProfileVersion,
  PutTooth,
  ServerHealth,
  Station,
  ToothImport,
  ToothWanted,
} from "./types";

interface PageQuery {
  readonly cursor?: string | undefined;
  readonly limit?: number;
}

interface ListedDevices {
  readonly devices: readonly ListedDevice[];
}

// Stations and how they are enrolled, and the devices that graded work is done with.
export class StationsApi {
  constructor(private readonly http: Http) {}

  list(query: PageQuery, signal?: AbortSignal) {
    return this.http.page<Station>("/stations", "stations", { ...query }, signal);
  }
  all(signal?: AbortSignal) {
    return this.http.all<Station>("/stations", "stations", {}, signal);
  }
  rename(id: string, name: string, tag: string) {
    return this.http.tagged<Station>("PATCH", `/stations/${segment(id)}`, { body: { name }, tag });
  }
  revoke(id: string) {
    return this.http.json<Station>("POST", `/stations/${segment(id)}/revoke`);
  }
  codes(signal?: AbortSignal) {
    return this.http.all<EnrolCode>("/enrolment-codes", "codes", {}, signal);
  }
  makeCode(minutes: number) {
    return this.http.json<MadeEnrolCode>("POST", "/enrolment-codes", { body: { minutes } });
  }
  withdrawCode(id: string) {
    return this.http.empty("DELETE", `/enrolment-codes/${segment(id)}`);
  }
  // Haptic devices that are allowed for graded work. Each change answers with all of them.
  devices(signal?: AbortSignal) {
    return this.http.json<ListedDevices>("GET", "/listed-devices", { signal });
  }
  listDevice(name: string, title: string) {
    return this.http.json<ListedDevices>("POST", "/listed-devices", { body: { name, title } });
  }
  unlistDevice(name: string) {
    return this.http.json<ListedDevices>("POST", "/listed-devices/remove", { body: { name } });
  }
}

// Device profiles, their reports and calibrations.
export class ProfilesApi {
  constructor(private readonly http: Http) {}

  list(query: PageQuery, signal?: AbortSignal) {
    return this.http.page<Profile>("/profiles", "profiles", { ...query }, signal);
  }
  get(name: string, signal?: AbortSignal) {
    return this.http.json<ProfileDetail>("GET", profilePath(name), { signal });
  }
  all(signal?: AbortSignal) {
    return this.http.all<Profile>("/profiles", "profiles", {}, signal);
  }
  // `text`: a device profile (schemas/device_profile.schema.json), sent unchanged. One that its
  // criteria refuse is not saved; the judgement then says why. `check`: only checks it, without
  // storing it.
  async upload(
    text: string,
    { check = false, signal }: { readonly check?: boolean; readonly signal?: AbortSignal } = {},
  ): Promise<ApiResult<ProfileJudgement>> {
    const result = await this.http.json<ProfileJudgement>("POST", `/profiles${check ? "?dry_run=true" : ""}`, {
      body: text,
      type: "application/json",
      signal,
    });
    if (!result.ok && Array.isArray(result.error.answer?.["criteria"]))
      return ok(result.error.answer as unknown as ProfileJudgement);
    return result;
  }
  versions(name: string, signal?: AbortSignal) {
    return this.http.all<ProfileVersion>(`${profilePath(name)}/versions`, "versions", {}, signal);
  }
  reports(name: string, signal?: AbortSignal) {
    return this.http.all<ProfileReport>(`${profilePath(name)}/reports`, "reports", {}, signal);
  }
  addReport(name: string, text: string, type: "application/json" | "text/html") {
    return this.http.json<ProfileReport>("POST", `${profilePath(name)}/reports`, { body: text, type });
  }
  // A JSON report as it was attached; what is in it is for the reader to check.
  report(id: string, signal?: AbortSignal) {
    return this.http.json<Readonly<Record<string, unknown>>>("GET", `/profile-reports/${segment(id)}`, { signal });
  }
  reportAddress(id: string): string {
    return `/api/v1/profile-reports/${segment(id)}`;
  }
  // Newest first.
  calibrations(name: string, signal?: AbortSignal) {
    return this.http.all<Calibration>(`${profilePath(name)}/calibrations`, "calibrations", {}, signal);
  }
  // `text`: a calibration (schemas/calibration.schema.json), sent unchanged.
  addCalibration(name: string, text: string) {
    return this.http.json<Calibration>("POST", `${profilePath(name)}/calibrations`, {
      body: text,
      type: "application/json",
    });
  }
}

const kPartBytes = 512 * 1024; // of a mesh, in one request: the server takes 1 MiB

export interface AuditQuery extends PageQuery {
  readonly actor?: string;
  readonly action?: string;
  readonly object?: string;
  readonly from_ms?: number | undefined;
  readonly until_ms?: number | undefined;
}

// The server's own work, and who changed what.
export class OperationsApi {
  constructor(private readonly http: Http) {}

  jobs(query: PageQuery & { readonly state?: string }, signal?: AbortSignal) {
    return this.http.page<Job>("/jobs", "jobs", { ...query }, signal);
  }
  health(signal?: AbortSignal) {
    return this.http.json<ServerHealth>("GET", "/health", { signal });
  }
  startBackup() {
    return this.http.json<Backups>("POST", "/backups");
  }
  // Those that the server can make itself, and making one.
  async teeth(
    signal?: AbortSignal,
  ): Promise<ApiResult<ReadonlyArray<{ readonly name: string; readonly summary: string }>>> {
    const result = await this.http.json<{
      readonly teeth: ReadonlyArray<{ readonly name: string; readonly summary: string }>;
    }>("GET", "/builtin-teeth", { signal });
    return result.ok ? ok(result.value.teeth) : result;
  }
  putTooth(name: string) {
    return this.http.json<PutTooth>("POST", "/builtin-teeth", { body: { name } });
  }
  // Sends a mesh in parts and asks until it is done or refused; `onChange` hears of each step. If
  // the person leaves before all of it was sent, the server forgets the upload.
  async importTooth(
    file: File,
    about: ToothWanted,
    onChange: (now: ToothImport) => void,
    pollMs: number,
    signal: AbortSignal,
  ): Promise<ApiResult<ToothImport>> {
    let now = await this.http.json<ToothImport>("POST", "/tooth-imports", {
      body: { file_name: file.name, bytes: file.size, ...about },
    });
    while (now.ok) {
      const { id, state, received } = now.value;
      const path = `/tooth-imports/${segment(id)}`;
      if (signal.aborted) {
        if (state === "receiving") await this.http.empty("DELETE", path);
        return now;
      }
      onChange(now.value);
      if (state === "done" || state === "refused") return now;
      if (state === "receiving") {
        const part = file.slice(received, received + kPartBytes);
        now = await this.http.json<ToothImport>("PUT", `${path}/bytes?offset=${received}`, {
          body: part,
          type: "application/octet-stream",
        });
      } else {
        await new Promise((done) => setTimeout(done, pollMs));
        now = await this.http.json<ToothImport>("GET", path);
      }
    }
    return now;
  }
  // Of an import that was shown and not published.
  shownTooth(id: string, what: "surface" | "start-tooth", signal?: AbortSignal) {
    return this.http.bytes(`/tooth-imports/${segment(id)}/${what}`, signal);
  }
  cancelJob(id: string) {
    return this.http.empty("POST", `/jobs/${segment(id)}/cancel`);
  }
  audit(query: AuditQuery, signal?: AbortSignal) {
    return this.http.page<AuditEntry>("/audit", "audit", { ...query }, signal);
  }
}

function profilePath(name: string): string {
  return `/profiles/${segment(name)}`;
}
