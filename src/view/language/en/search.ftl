# The search field and its suggestions.

search-date = date
search-julian = { $julian } (Julian) = { $date } (Gregorian)
search-place = place on { $body }
search-events = search for events
search-city = city, { $country }
search-key = shader key
search-near = near { $body }
search-body = body
search-star = star, magnitude { $magnitude }
search-comet = comet
search-minor-planet = minor planet
search-constellation = constellation
search-moment = moment, { $day }
search-on = on { $body }
search-effect = effect: opens the Effects panel
search-of-year = {" "}of { $y }
search-from-day = { $kinds } from { $day } on
search-and = {" "}and{" "}
search-field-hint-text = Search (/)
search-hint = Bodies, stars, comets, minor planets, constellations, craters, cities, moments, views, dates, events (eclipse 2027), places (51.5, -0.1), effects, shader keys, links (/)
search = Search
search-nothing = Nothing is called “{ $typed }”
search-no-event = “{ $typed }”: events are found by kind and date, such as “eclipse 12 August 2026”. For a place, search for its city, then open Events
search-no-place = “{ $typed }” is not a place: latitudes are -90 to 90 degrees, longitudes -360 to 360
search-effects-switched = Effects switched by hand: { $effects } (to undo: Effects, “Reset to automatic”)
search-did-you-mean = Did you mean { $name }?
search-city-chosen = { $city }, { $country }: events, rise and set now refer to this place
search-star-outside = HIP { $hip }: outside the range of the ephemeris of { $body }
