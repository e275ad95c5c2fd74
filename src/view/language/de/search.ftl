# The search field and its suggestions.

search-date = Datum
search-julian = { $julian } (julianisch) = { $date } (gregorianisch)
search-place = Ort auf: { $body }
search-events = Ereignisse suchen
search-city = Stadt, { $country }
search-key = Shader-Schlüssel
search-near = bei: { $body }
search-body = Körper
search-star = Stern, Helligkeit { $magnitude }
search-comet = Komet
search-minor-planet = Kleinplanet
search-constellation = Sternbild
search-moment = Moment, { $day }
search-on = auf: { $body }
search-effect = Effekt: öffnet die Effekte
search-of-year = {" "}{ $y }
search-from-day = { $kinds } ab { $day }
search-and = {" "}und{" "}
search-field-hint-text = Suche (/)
search-hint = Körper, Sterne, Kometen, Kleinplaneten, Sternbilder, Krater, Städte, Momente, Ansichten, Daten, Ereignisse (Finsternis 2027), Orte (51,5; -0,1), Effekte, Shader-Schlüssel, Links (/)
search = Suche
search-nothing = Nichts heißt „{ $typed }“
search-no-event = „{ $typed }“: Ereignisse findet man nach Art und Datum, etwa „Finsternis 12. August 2026“. Für einen Ort: die Stadt suchen, dann Ereignisse öffnen
search-no-place = „{ $typed }“ ist kein Ort: Breiten liegen zwischen -90 und 90 Grad, Längen zwischen -360 und 360
search-effects-switched = Von Hand geschaltete Effekte: { $effects } (zurück: Effekte, „Auf Automatik zurücksetzen“)
search-did-you-mean = Vielleicht { $name }?
search-city-chosen = { $city }, { $country }: Ereignisse, Auf- und Untergang gelten ab jetzt für diesen Ort
search-star-outside = HIP { $hip }: außerhalb des Bereichs der Ephemeride für: { $body }
