// Index page: shows the modules whose key contains every word of the filter and no word that follows a minus sign.
const filter = document.getElementById("filter");
if (filter) {
  const rows = [...document.querySelectorAll(".modules li")].map((row) => [row, row.querySelector("span").textContent]);
  const apply = () => {
    const words = filter.value.toLowerCase().split(/\s+/).filter((word) => word && word !== "-");
    let shown = 0;
    for (const [row, key] of rows) {
      const fits = words.every((word) => (word[0] === "-" ? !key.includes(word.slice(1)) : key.includes(word)));
      row.hidden = !fits;
      shown += fits;
    }
    document.getElementById("count").textContent = `${shown} shown`;
  };
  const applyAddress = () => {
    const hash = location.hash.slice(1);
    try {
      filter.value = decodeURIComponent(hash);
    } catch {
      // A link that was typed or cut may have a percent sign that encodes nothing: it is taken as it is.
      filter.value = hash;
    }
    apply();
  };
  filter.addEventListener("input", () => {
    history.replaceState(null, "", `#${encodeURIComponent(filter.value)}`);
    apply();
  });
  // Does not follow replaceState, only an address that the user edits or opens.
  window.addEventListener("hashchange", applyAddress);
  applyAddress();
}

// Module page: assembles the module's source from the table of lines (lines.js). Each line has the colour of the feature
// that includes it.
const source = document.getElementById("source");
if (source) {
  const seen = new Map();
  const colour = (feature) => {
    // 137 degrees, about the golden angle, keeps the hues of successive features apart.
    if (!seen.has(feature)) seen.set(feature, `hsl(${(seen.size * 137) % 360} 45% 86%)`);
    return seen.get(feature);
  };
  let number = 0;
  for (const run of source.dataset.runs.split(";")) {
    const [first, count] = run.split(",").map(Number);
    for (const [text, fragment, line, feature] of LINES.slice(first, first + count)) {
      number += 1;
      const row = document.createElement("div");
      row.id = `L${number}`;
      row.dataset.number = number;
      row.style.background = colour(FEATURES[feature]);
      row.title = `${FEATURES[feature]}: shaders/${FRAGMENTS[fragment]}, line ${line}`;
      row.textContent = text || " ";
      source.append(row);
    }
  }
  const legend = document.getElementById("legend");
  for (const [feature, background] of seen) {
    const mark = document.createElement("span");
    mark.textContent = feature;
    mark.style.background = background;
    legend.append(mark, " ");
  }
}
