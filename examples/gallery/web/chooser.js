// The tables at the top, the explanation, and the switch between light and dark.
const summaries = new Map(results.chooser.summaries.map((summary) => [summary.name, summary]));
const limitsOf = (summary) => summary.limits.join("; ") || "none measured";
const costText = (summary) => `${times(summary.rest)} at rest, ${times(summary.moving)} moving`;
function errorText(summary) {
  const parts = [];
  if (isNumber(summary.hard)) parts.push(`${percent(summary.hard)} wrong`);
  if (isNumber(summary.soft)) parts.push(`soft RMSE ${rmse(summary.soft)}`);
  return parts.join(", ") || "–";
}

function buildChoices() {
  const heads = ["You want", "Technique", "Error", "Cost", "Limits"].map((text) => element("th", { scope: "col" }, text));
  const lines = results.chooser.choices.map(({ want, name }) => {
    const summary = summaries.get(name);
    return element("tr", {}, element("td", { class: "want" }, want), element("th", { scope: "row", class: "way" }, summary.title),
      element("td", { "data-label": "Error" }, errorText(summary)), element("td", { "data-label": "Cost" }, costText(summary)),
      element("td", { class: "limits", "data-label": "Limits" }, limitsOf(summary)));
  });
  byId("choices").append(
    element("thead", {}, element("tr", {}, ...heads)), element("tbody", {}, ...lines));
}

// Columns of the table of everything: heading, key of the summary, text.
const COLUMNS = [
  ["Technique", "title", (summary) => summary.title],
  ["Wrong, hard light", "hard", (summary) => percent(summary.hard)],
  ["RMSE, soft light", "soft", (summary) => rmse(summary.soft)],
  ["Cost at rest", "rest", (summary) => times(summary.rest)],
  ["Cost moving", "moving", (summary) => times(summary.moving)],
  ["Shots", "shots", (summary) => `${summary.shots}`],
  ["Limits", "limits", limitsOf],
];

function fillMeasured(order) {
  const body = byId("measured").querySelector("tbody");
  const best = Object.fromEntries(["hard", "soft", "rest", "moving"].map((key) =>
    [key, Math.min(...[...summaries.values()].map((summary) => (isNumber(summary[key]) ? summary[key] : Infinity)))]));
  body.replaceChildren(...order.map((summary) => element("tr", {}, ...COLUMNS.map(([, key, text]) => {
    if (key === "title") return element("th", { scope: "row", class: "way" }, text(summary));
    const classes = [key === "limits" ? "limits" : "number", summary[key] === best[key] ? "best" : ""].join(" ").trim();
    return element("td", { class: classes || null }, text(summary));
  }))));
}

// Sorts by a column; a second time the other way round. What has no number comes last.
function sortMeasured(key, head) {
  const direction = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
  for (const other of byId("measured").querySelectorAll("th[aria-sort]")) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", direction > 0 ? "ascending" : "descending");
  const order = [...summaries.values()].sort((a, b) => {
    const [left, right] = [a[key], b[key]].map((value) => (Array.isArray(value) ? value.length : value));
    if (left === null || right === null) return (left === null) - (right === null);
    return direction * (typeof left === "string" ? left.localeCompare(right) : left - right);
  });
  fillMeasured(order);
}

function buildMeasured() {
  const heads = COLUMNS.map(([text, key]) => {
    const head = element("th", { scope: "col", class: key === "title" || key === "limits" ? null : "number" });
    head.append(element("button", { type: "button", "data-sort": key, onclick: () => sortMeasured(key, head) }, text));
    return head;
  });
  byId("measured").append(element("thead", {}, element("tr", {}, ...heads)), element("tbody"));
  fillMeasured([...summaries.values()]);
}

function buildMethod() {
  const software = results.software
    ? " This is a software renderer: times are those of CPU cores, good for ratios within this page only." : "";
  const colour = (value, text) => element("li", {}, element("i", { style: `background:${value}` }), text);
  byId("method").append(
    element("p", {}, "The truth comes from a ray caster on the CPU, which reads the same scene and shares nothing else with the renderer. " +
      "Only pixels count that face the light within its reach."),
    element("p", {}, "Hard light: the share of pixels that are off by more than ½, without a band of one pixel around the truth’s edges, where " +
      `one ray cannot tell. Soft light: root mean squared error over the penumbra, against ${results.samples} rays at every pixel.`),
    element("p", {}, "Cost: GPU time of the light’s passes with shadows over that of the same light without them, other lights off, " +
      `median of ${results.runs} frames. At rest nothing moves, so a technique may reuse what it drew. Moving, the light moves in every frame.`),
    element("p", {}, `Errors and geometry are drawn at ${results.size.join("×")} pixels, and pictures at ${results.scale} times that, ` +
      "each pixel the mean of four. The truth’s picture is what the renderer draws of each light without shadows, times the ray-cast visibility."),
    element("ul", { class: "legend" }, colour("#ff5418", "too bright"), colour("#1e90ff", "too dark"),
      colour("#00ff00", "right, lit"), colour("#008000", "right, in shadow"), colour("#ff0000", "wrong"), colour("#606060", "does not count")));
  byId("intro").textContent = `${results.scenes.length} scenes, ${results.techniques.length} techniques, each beside what rays say.`;
  const more = results.more.flatMap(({ file, title }) => [element("a", { href: file }, title), " · "]);
  byId("footer").append(element("p", {}, `${results.adapter}.${software}`),
    element("p", {}, `Drawn in ${Math.round(results.seconds)} s. ${results.verdict}.`),
    element("p", {}, ...more, element("a", { href: "results.json" }, "All numbers as JSON")));
}

// Without a choice of the reader, the system's setting counts.
const THEMES = ["system", "light", "dark"];
const remembered = (() => { try { return localStorage.getItem("theme"); } catch { return null; } })();
function setTheme(theme) {
  if (theme === "system") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme;
  byId("theme").textContent = { system: "◐ System", light: "☀ Light", dark: "☾ Dark" }[theme];
  byId("theme").setAttribute("aria-label", `Colours: ${theme}. Change`);
  byId("theme").dataset.now = theme;
  try { localStorage.setItem("theme", theme); } catch { /* A page of a file may have no storage. */ }
}
byId("theme").addEventListener("click", () => setTheme(THEMES[(THEMES.indexOf(byId("theme").dataset.now) + 1) % THEMES.length]));
setTheme(THEMES.includes(remembered) ? remembered : "system");

buildChoices();
buildMeasured();
buildMethod();
