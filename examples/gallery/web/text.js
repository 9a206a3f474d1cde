// The data, elements, and numbers as text.
const results = JSON.parse(document.getElementById("results").textContent);
const byId = (id) => document.getElementById(id);

// An element with attributes, and children that are nodes or text. A property that is null is left out.
function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

const isNumber = (value) => typeof value === "number" && Number.isFinite(value);
const times = (value) => (isNumber(value) ? `${value.toFixed(value < 9.95 ? 2 : 1)}×` : "–");
const percent = (share) => {
  if (!isNumber(share)) return "–";
  if (share === 0) return "0 %";
  return share < 5e-5 ? "< 0.01 %" : `${(100 * share).toFixed(share < 0.0995 ? 2 : 1)} %`;
};
const rmse = (value) => (isNumber(value) ? value.toFixed(value < 0.0995 ? 4 : 3) : "–");

// The number by which ways of a shot are compared, and its text.
function errorOf(shot, way) {
  if (!way.error) return { value: Infinity, text: "–" };
  if (shot.soft) {
    const value = way.error.rmse_penumbra;
    return { value: isNumber(value) ? value : Infinity, text: rmse(value) };
  }
  // Of ways with equally many wrong pixels, the one with the smaller mean error is better.
  const { share, rmse: mean } = way.error;
  return { value: isNumber(share) ? share + 1e-6 * (mean || 0) : Infinity, text: percent(share) };
}

const costOf = (way, kind) => (way.cost && isNumber(way.cost[kind]) ? way.cost[kind] : Infinity);

// A group of radio buttons that look like one control.
function choice(field, name, options, chosen, onchange) {
  for (const [value, text] of options) {
    const input = element("input", { type: "radio", name, value, checked: value === chosen });
    input.addEventListener("change", () => input.checked && onchange(value));
    field.append(element("label", { class: "choice" }, input, element("span", {}, text)));
  }
}

const VIEWS = [["picture", "Picture"], ["visibility", "Visibility"], ["difference", "Error"], ["volumes", "Geometry"]];
const EXACT = (view) => view !== "picture";

// File of a picture: of a way, or of the truth, which has no error and no geometry. Null if there is none.
function fileOf(shot, way, view) {
  const pictures = way === null ? shot.truth : way.pictures;
  return (pictures && pictures[view]) || null;
}
