// The first page: what the daemon does now and has done. Plain DOM over the public API; all text goes through
// textContent. It asks again every second while it is looked at.

const kAskEveryMs = 1000;
const kPreviewEveryMs = 3000;
const kQueueShown = 50;
const kFinishedShown = 12;
const kComparisonsShown = 20;

const byId = (id) => document.getElementById(id);
const signIn = byId("sign-in");

class NeedsToken extends Error {}

/** An answer of the daemon, with the token where one was given. */
async function ask(path) {
  const token = sessionStorage.getItem("token");
  const answer = await fetch(path, { headers: token ? { Authorization: `Bearer ${token}` } : {} });
  if (answer.status === 401 || answer.status === 403) throw new NeedsToken();
  return answer;
}

async function askList(path) {
  const answer = await ask(path);
  if (!answer.ok) throw new Error(`${path}: ${answer.status}`);
  return answer.json();
}

function element(name, text, className) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  if (className) made.className = className;
  return made;
}

/** A link; with a token the browser cannot follow it by itself, so that the file is fetched and saved. */
function link(text, path) {
  const made = element("a", text);
  made.href = path;
  made.addEventListener("click", async (event) => {
    if (!sessionStorage.getItem("token")) return;
    event.preventDefault();
    const file = URL.createObjectURL(await (await ask(path)).blob());
    const save = element("a");
    save.href = file;
    save.download = path.split("/").slice(-2).join("-");
    save.click();
    setTimeout(() => URL.revokeObjectURL(file), 60_000);
  });
  return made;
}

function seconds(value) {
  if (value === null || value === undefined) return "";
  if (value < 10) return `${value.toFixed(2)} s`;
  if (value < 120) return `${value.toFixed(1)} s`;
  if (value < 7200) return `${(value / 60).toFixed(1)} min`;
  return `${(value / 3600).toFixed(1)} h`;
}

const errorText = (error) => (error && error.value !== null ? `${error.metric} ${error.value.toPrecision(3)}` : "");
const sizeText = (image) => `${image.width} × ${image.height}`;

function stopText(stop) {
  const parts = [];
  if (stop.passes) parts.push(`${stop.passes} passes`);
  if (stop.seconds) parts.push(seconds(stop.seconds));
  if (stop.target) parts.push(`${stop.target.metric} ≤ ${stop.target.value}`);
  return parts.join(" or ");
}

function methodText(job) {
  const role = job.role === "reference" ? " (reference)" : job.role === "merged" ? " (merged)" : "";
  return job.request.method.name + role;
}

/** Fills a table with rows of cells; each cell is a text or a node. */
function fill(id, rows) {
  byId(id).hidden = rows.length === 0;
  byId(`${id}-none`).hidden = rows.length > 0;
  byId(id).tBodies[0].replaceChildren(
    ...rows.map((cells) => {
      const row = element("tr");
      for (const cell of cells) {
        const td = element("td");
        td.append(cell ?? "");
        row.append(td);
      }
      return row;
    }),
  );
}

/** Cards of running jobs, kept from one look to the next so that their pictures do not flicker. */
class RunningCards {
  #cards = new Map();

  show(jobs) {
    const now = new Set(jobs.map((job) => job.id));
    for (const [id, card] of this.#cards)
      if (!now.has(id)) {
        card.root.remove();
        if (card.url) URL.revokeObjectURL(card.url);
        this.#cards.delete(id);
      }
    for (const job of jobs) this.#update(job);
    byId("running-none").hidden = jobs.length > 0;
  }

  #update(job) {
    let card = this.#cards.get(job.id);
    if (!card) {
      card = { root: element("article", undefined, "card"), image: element("img"), text: element("div") };
      card.image.alt = "";
      card.title = element("p");
      card.bar = element("progress");
      card.bar.max = 1;
      card.facts = element("p");
      card.error = element("p");
      card.title.append(element("strong", job.id), ` ${job.request.scene}, ${methodText(job)}`);
      card.text.append(card.title, card.bar, card.facts, card.error);
      card.root.append(card.image, card.text);
      byId("running").append(card.root);
      this.#cards.set(job.id, card);
    }
    card.bar.value = job.progress;
    card.facts.textContent =
      `${sizeText(job.request.image)}, ${job.passes_done} passes, ${seconds(job.seconds)}` +
      (stopText(job.request.stop) ? `; until ${stopText(job.request.stop)}` : "");
    card.error.textContent = errorText(job.error_now);
    const due = performance.now() - (card.asked ?? -Infinity) > kPreviewEveryMs;
    if (due && job.passes_done > (card.shown ?? 0)) {
      card.asked = performance.now();
      card.shown = job.passes_done;
      this.#preview(job, card).catch(() => {});
    }
  }

  async #preview(job, card) {
    const answer = await ask(job.links.preview);
    if (answer.status !== 200) return;
    const url = URL.createObjectURL(await answer.blob());
    card.image.src = url;
    card.image.alt = `${job.id} so far`;
    if (card.url) URL.revokeObjectURL(card.url);
    card.url = url;
  }
}

const cards = new RunningCards();

function showQueue(page, waiting) {
  byId("queue-size").textContent = waiting > kQueueShown ? `(${waiting}, the last ${kQueueShown} shown)` : "";
  fill(
    "queue",
    page.items.map((job) => [
      job.id,
      job.request.scene,
      methodText(job),
      sizeText(job.request.image),
      stopText(job.request.stop),
      String(job.request.priority),
    ]),
  );
}

function comparisonRow(comparison) {
  const labels = (comparison.request.entries ?? []).map((entry) => entry.label).join(", ");
  const over = !["queued", "running"].includes(comparison.state);
  const done = over ? comparison.state : `${comparison.state}, ${Math.round(100 * (comparison.progress ?? 0))} %`;
  const report = element("span");
  const self = `/v1/comparisons/${comparison.id}`;
  if (comparison.state !== "queued")
    report.append(link(over ? "report" : "so far", `${self}/report.html`), " · ", link("CSV", `${self}/report.csv`));
  return [
    element("strong", comparison.id),
    comparison.request.scene,
    labels,
    element("span", done, comparison.state === "failed" ? "failed" : ""),
    report,
  ];
}

function finishedRow(job) {
  const image = element("span");
  if (job.passes_done > 0 && job.state !== "failed")
    image.append(link("PNG", job.links.preview), " · ", link("EXR", job.links.image));
  const state = element("span", job.state, job.state === "failed" ? "failed" : "");
  if (job.failure) state.title = job.failure.detail;
  return [
    element("strong", job.id),
    job.request.scene,
    methodText(job),
    state,
    String(job.passes_done),
    seconds(job.seconds),
    errorText(job.error_now),
    image,
  ];
}

async function look() {
  const [status, running, queued, comparisons, jobs] = await Promise.all([
    askList("/v1/status"),
    askList("/v1/jobs?state=running&limit=20"),
    askList(`/v1/jobs?state=queued&limit=${kQueueShown}`),
    askList(`/v1/comparisons?limit=${kComparisonsShown}`),
    askList(`/v1/jobs?limit=${kFinishedShown * 3}`),
  ]);
  const daemon = byId("daemon");
  daemon.className = "";
  daemon.textContent =
    `version ${status.version}, up ${seconds(status.uptime_seconds)}, ` +
    `${status.queue.running} running, ${status.queue.queued} waiting` +
    (status.ready ? "" : ", not every process has answered");
  cards.show(running.items);
  showQueue(queued, status.queue.queued);
  fill("comparisons", comparisons.items.map(comparisonRow));
  const over = jobs.items.filter((job) => ["succeeded", "failed", "cancelled"].includes(job.state));
  fill("finished", over.slice(0, kFinishedShown).map(finishedRow));
  signIn.hidden = true;
}

signIn.addEventListener("submit", (event) => {
  event.preventDefault();
  sessionStorage.setItem("token", byId("token").value);
  byId("token").value = "";
});

async function lookAgain() {
  try {
    if (!document.hidden) await look();
  } catch (failure) {
    const daemon = byId("daemon");
    daemon.className = "lost";
    if (failure instanceof NeedsToken) {
      signIn.hidden = false;
      daemon.textContent = "not signed in";
    } else {
      daemon.textContent = `the daemon does not answer (${failure.message})`;
    }
  }
  setTimeout(lookAgain, kAskEveryMs);
}

lookAgain();
